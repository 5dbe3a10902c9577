//! From command line and file to [`Settings`]: a flag beats the file, the file beats the default.

use super::error::ConfigError;
use super::file::{
    ConfigFile, FillSection, FindSection, LimitWord, PlaceWord, RegionSection, RunSection, SceneSection,
};
use super::memory::{Machine, MemoryLimit};
use super::polygon::PolygonFile;
use super::settings::{
    AreaLimit, AreaSettings, FillSettings, FindSettings, MethodName, Region, RegionPlace, RunSettings,
    SceneSettings, Selection, Settings,
};
use super::values::AreaArgument;
use super::water::WaterFile;
use crate::cli::{Cli, Command, FillArgs, FindArgs, RunArgs, SceneArgs, SelectionArgs};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// The arguments that verbs share, whatever the verb.
#[derive(Default)]
struct Arguments {
    config: Option<PathBuf>,
    input: Option<PathBuf>,
    output: Option<PathBuf>,
    reading: SceneArgs,
    find: FindArgs,
    selection: SelectionArgs,
    fill: FillArgs,
    run: RunArgs,
    repair: RepairOnly,
}

/// What `repair` alone has.
#[derive(Default)]
struct RepairOnly {
    is_repair: bool,
    untouched: Option<super::settings::Untouched>,
    fail_on: Option<super::settings::FailOn>,
    strict: bool,
    overwrite: bool,
    dry_run: bool,
}

/// More threads than any machine that runs this has processors.
const MOST_THREADS: usize = 1024;

impl Settings {
    /// Joins defaults, the configuration file and the flags, on this machine.
    ///
    /// # Errors
    /// A configuration file, polygon file or tile list that cannot be used; a missing scene or output; settings that
    /// do not go together; what is not in this version. Exit code 2.
    pub fn resolve(cli: &Cli) -> Result<Self, ConfigError> {
        Self::resolve_on(cli, &Machine::detect())
    }

    /// The same for a given machine.
    ///
    /// # Errors
    /// As [`Settings::resolve`].
    pub fn resolve_on(cli: &Cli, machine: &Machine) -> Result<Self, ConfigError> {
        let arguments = arguments(&cli.command)?;
        let (file, folder) = match &arguments.config {
            Some(path) => (ConfigFile::read(path)?, path.parent().unwrap_or(Path::new("")).to_owned()),
            None => (ConfigFile::default(), PathBuf::new()),
        };
        let default = FillSettings::default();
        let base = FillSettings {
            water: file.water.mode.unwrap_or_default(),
            islands: file.water.islands.unwrap_or_default(),
            max_unknowns: file.field.max_unknowns.unwrap_or(default.max_unknowns),
            ..default
        };
        let water_file = |path: &PathBuf| WaterFile::read(&folder.join(path));
        let fill = fill(&file.fill, base);
        let settings = Self {
            scene: scene(&file.scene, &arguments, &folder),
            area: AreaSettings {
                limit: limit(file.area.limit.as_ref(), arguments.find.area.as_ref(), &folder)?,
                external: arguments.find.external.or(file.area.external).unwrap_or_default(),
            },
            run: run(&file.run, &arguments, machine),
            find: find(&file.find, &arguments.find),
            fill: fill_flags(&arguments.fill, fill),
            water_polygons: file.water.polygons.as_ref().map(water_file).transpose()?,
            regions: regions(&file.regions, &arguments.fill, fill, &folder)?,
            selection: selection(&arguments.selection)?,
        };
        check(&settings, &cli.command)?;
        Ok(settings)
    }

    /// The settings that shape the output, for the report: no path, memory limit, thread count or time.
    #[must_use]
    pub fn to_json(&self) -> serde_json::Value {
        serde_json::json!({
            "scene": {
                "untouched": self.scene.untouched,
                "cell_size_m": self.scene.cell_size_m,
                "cell_origin_m": self.scene.cell_origin_m,
                "up_axis": self.scene.up_axis,
                "srs": self.scene.srs,
                "srs_origin": self.scene.srs_origin,
            },
            "area": self.area,
            "find": self.find,
            "fill": self.fill,
            "water_polygons": self.water_polygons,
            "regions": self.regions,
            "selection": self.selection,
        })
    }

    /// The settings that change how a run goes, for the report's run facts.
    #[must_use]
    pub fn run_facts(&self) -> serde_json::Value {
        let area_file = match &self.area.limit {
            AreaLimit::Polygon(file) => Some(file.path.display().to_string()),
            AreaLimit::Cells | AreaLimit::Box => None,
        };
        let water_file = self.water_polygons.as_ref().map(|file| file.path.display().to_string());
        serde_json::json!({ "run": self.run, "area_file": area_file, "water_file": water_file })
    }
}

fn arguments(command: &Command) -> Result<Arguments, ConfigError> {
    Ok(match command {
        Command::Info(info) => Arguments {
            input: info.scene.clone().or_else(|| info.input.clone()),
            reading: info.reading.clone(),
            run: info.run.clone(),
            ..Arguments::default()
        },
        Command::Inspect(inspect) => Arguments {
            config: inspect.config.clone(),
            input: inspect.scene.clone().or_else(|| inspect.input.clone()),
            reading: inspect.reading.clone(),
            find: inspect.find.clone(),
            selection: inspect.selection.clone(),
            fill: inspect.fill.clone(),
            run: inspect.run.clone(),
            ..Arguments::default()
        },
        Command::Repair(repair) => repair_arguments(repair)?,
        Command::Verify(verify) => Arguments {
            input: verify.scene.clone().or_else(|| verify.input.clone()),
            output: verify.digest.clone().or_else(|| verify.out.clone()).or_else(|| verify.output.clone()),
            run: verify.run.clone(),
            ..Arguments::default()
        },
        Command::Bench(_) => {
            return Err(ConfigError::Settings(
                "bench has a configuration of its own and no settings".to_owned(),
            ));
        }
    })
}

fn repair_arguments(repair: &crate::cli::RepairArgs) -> Result<Arguments, ConfigError> {
    if repair.resume {
        let help = "the same command on OUT does everything again; --overwrite starts anew";
        return Err(not_built("--resume", Some(help)));
    }
    Ok(Arguments {
        config: repair.config.clone(),
        input: repair.scene.clone().or_else(|| repair.input.clone()),
        output: repair.out.clone().or_else(|| repair.output.clone()),
        reading: repair.reading.clone(),
        find: repair.find.clone(),
        selection: repair.selection.clone(),
        fill: repair.fill.clone(),
        run: repair.run.clone(),
        repair: RepairOnly {
            is_repair: true,
            untouched: repair.untouched,
            fail_on: repair.fail_on,
            strict: repair.strict,
            overwrite: repair.overwrite,
            dry_run: repair.dry_run,
        },
    })
}

fn not_built(what: &str, help: Option<&str>) -> ConfigError {
    ConfigError::NotInThisVersion { what: what.to_owned(), help: help.map(str::to_owned) }
}

fn scene(file: &SceneSection, arguments: &Arguments, folder: &Path) -> SceneSettings {
    let flags = &arguments.reading;
    let beside = |path: &PathBuf| folder.join(path);
    let reads_file = arguments.repair.is_repair;
    SceneSettings {
        input: arguments.input.clone().or_else(|| file.input.as_ref().map(beside)).unwrap_or_default(),
        output: arguments.output.clone().or_else(|| file.output.as_ref().filter(|_| reads_file).map(beside)),
        untouched: arguments.repair.untouched.or(file.untouched).unwrap_or_default(),
        cell_size_m: flags.cell_size.or(file.cell_size_m),
        cell_origin_m: flags.cell_origin.or(file.cell_origin_m.map(|(x, y)| [x, y])),
        up_axis: flags.up_axis.or(file.up_axis),
        srs: flags.srs.clone().or_else(|| file.srs.clone()),
        srs_origin: flags.srs_origin.or(file.srs_origin.map(|(x, y, z)| [x, y, z])),
    }
}

fn limit(
    file: Option<&LimitWord>,
    flag: Option<&AreaArgument>,
    folder: &Path,
) -> Result<AreaLimit, ConfigError> {
    Ok(match (flag, file) {
        (Some(AreaArgument::Cells), _) | (None, None | Some(LimitWord::Cells)) => AreaLimit::Cells,
        (Some(AreaArgument::Box), _) | (None, Some(LimitWord::Box)) => AreaLimit::Box,
        (Some(AreaArgument::File(path)), _) => AreaLimit::Polygon(PolygonFile::read(path)?),
        (None, Some(LimitWord::Polygon(path))) => AreaLimit::Polygon(PolygonFile::read(&folder.join(path))?),
    })
}

fn run(file: &RunSection, arguments: &Arguments, machine: &Machine) -> RunSettings {
    let memory = arguments.run.memory.or(file.memory).unwrap_or(MemoryLimit::DEFAULT);
    let threads = match arguments.run.threads.or(file.threads) {
        None | Some(0) => machine.threads,
        Some(count) => count,
    };
    RunSettings {
        memory_limit_bytes: memory.bytes_on(machine),
        threads: threads.clamp(1, MOST_THREADS),
        fail_on: arguments.repair.fail_on.or(file.fail_on).unwrap_or_default(),
        strict: arguments.repair.strict,
        untrusted: arguments.run.untrusted,
        overwrite: arguments.repair.overwrite,
        dry_run: arguments.repair.dry_run,
    }
}

fn find(file: &FindSection, flags: &FindArgs) -> FindSettings {
    FindSettings {
        min_area_m2: flags.min_area.or(file.min_area_m2),
        max_area_m2: flags.max_area.or(file.max_area_m2),
        max_perimeter_m: flags.max_perimeter.or(file.max_perimeter_m),
        max_edges_around_hole: flags.max_edges_around_hole.or(file.max_edges_around_hole),
        class: sorted(if flags.class.is_empty() {
            file.class.clone().unwrap_or_default()
        } else {
            flags.class.clone()
        }),
        shape: sorted(if flags.shape.is_empty() {
            file.shape.clone().unwrap_or_default()
        } else {
            flags.shape.clone()
        }),
    }
}

fn sorted<T: Ord>(mut list: Vec<T>) -> Vec<T> {
    list.sort_unstable();
    list.dedup();
    list
}

fn fill(file: &FillSection, base: FillSettings) -> FillSettings {
    FillSettings {
        method: file.method.unwrap_or(base.method),
        closed: file.closed.unwrap_or(base.closed),
        open: file.open.unwrap_or(base.open),
        spacing_m: file.spacing_m.or(base.spacing_m),
        ..base
    }
}

fn fill_flags(flags: &FillArgs, base: FillSettings) -> FillSettings {
    FillSettings {
        method: flags.method.unwrap_or(base.method),
        closed: flags.closed.unwrap_or(base.closed),
        open: flags.open.unwrap_or(base.open),
        spacing_m: flags.spacing.or(base.spacing_m),
        ..base
    }
}

/// Regions: their own fill settings over the scene's, flags over both.
fn regions(
    file: &[RegionSection],
    flags: &FillArgs,
    base: FillSettings,
    folder: &Path,
) -> Result<Vec<Region>, ConfigError> {
    file.iter()
        .map(|section| {
            Ok(Region {
                name: section.name.clone(),
                at: place(&section.at, folder)?,
                skip: section.skip.clone(),
                fill: fill_flags(
                    flags,
                    fill(&section.fill, FillSettings { water: section.water.unwrap_or(base.water), ..base }),
                ),
                water: section.water,
            })
        })
        .collect()
}

fn place(word: &PlaceWord, folder: &Path) -> Result<RegionPlace, ConfigError> {
    Ok(match word {
        PlaceWord::Point(x, y) => RegionPlace::Point([*x, *y]),
        PlaceWord::Box(west, south, east, north) => RegionPlace::Box([*west, *south, *east, *north]),
        PlaceWord::Polygon(path) => RegionPlace::Polygon(PolygonFile::read(&folder.join(path))?),
    })
}

fn selection(flags: &SelectionArgs) -> Result<Selection, ConfigError> {
    Ok(Selection {
        regions: flags.region.clone(),
        cells: flags.cells.as_deref().map(tile_names).transpose()?,
        at: flags.at.clone(),
        holes: flags.hole.clone(),
    })
}

/// Reads a list of tiles: one name a line; blank lines and lines that start with `#` do not count.
fn tile_names(path: &Path) -> Result<BTreeSet<String>, ConfigError> {
    let text =
        fs::read_to_string(path).map_err(|source| ConfigError::Read { path: path.to_owned(), source })?;
    let names = text.trim_start_matches('\u{feff}').lines().map(str::trim);
    let names: BTreeSet<String> =
        names.filter(|n| !n.is_empty() && !n.starts_with('#')).map(str::to_owned).collect();
    if names.is_empty() {
        return Err(ConfigError::Cells { path: path.to_owned(), what: "names no tile".to_owned() });
    }
    Ok(names)
}

fn check(settings: &Settings, command: &Command) -> Result<(), ConfigError> {
    let fail = |text: String| Err(ConfigError::Settings(text));
    let needs_scene = !matches!(command, Command::Verify(v) if v.digest.is_some());
    if needs_scene && settings.scene.input.as_os_str().is_empty() {
        return fail("no scene; give its folder as SCENE, or scene: (input: ..) in --config".to_owned());
    }
    let needs_output = matches!(command, Command::Repair(r) if !r.dry_run);
    if needs_output && settings.scene.output.is_none() {
        return fail("no output folder; give OUT after SCENE, or scene: (output: ..) in --config".to_owned());
    }
    if let (Some(least), Some(most)) = (settings.find.min_area_m2, settings.find.max_area_m2)
        && least > most
    {
        return fail(format!(
            "the least area, {least} m2, is above the largest one, {most} m2; no hole fits"
        ));
    }
    check_regions(settings).map_or(Ok(()), fail)
}

/// What is wrong with the regions, if anything.
fn check_regions(settings: &Settings) -> Option<String> {
    for (k, region) in settings.regions.iter().enumerate() {
        let name = region.name.escape_debug();
        if settings.regions[..k].iter().any(|earlier| earlier.name == region.name) {
            return Some(format!("two regions are named {name}; give each a name of its own"));
        }
        if let RegionPlace::Box([west, south, east, north]) = region.at
            && !(west < east && south < north)
        {
            return Some(format!(
                "region {name}: a box is box(west, south, east, north), with west < east and south < north"
            ));
        }
        let merges = |fill: &FillSettings| fill.method == MethodName::Aggregate;
        if merges(&region.fill) != merges(&settings.fill) {
            return Some(format!(
                "region {name}: aggregate merges the whole scene, so no region has another method; leave its method out, \
                 or take field or layered for the scene"
            ));
        }
    }
    let known = |name: &String| settings.regions.iter().any(|region| region.name == *name);
    let unknown = settings.selection.regions.iter().find(|name| !known(name))?;
    let names: Vec<&str> = settings.regions.iter().map(|r| r.name.as_str()).collect();
    let list =
        if names.is_empty() { "it has none".to_owned() } else { format!("it has {}", names.join(", ")) };
    Some(format!("--region {}: no such region in the configuration; {list}", unknown.escape_debug()))
}
