//! What to measure: the bench's own configuration file (RON).

use crate::config::{ConfigError, Key, Machine, MemoryLimit, MethodName, key, parse_ron, version_one};
use clap::ValueEnum;
use scene::encode::Format;
use scene::preset::Preset;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};
use std::path::Path;

/// What to measure, defaults filled in.
#[derive(Clone, Debug, PartialEq)]
pub struct BenchConfig {
    /// In the order of the file.
    pub series: Vec<Series>,
}

/// Scenes of one kind that stand in one table and one picture, and how they are repaired.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Letters, digits, `-` and `_`; unique. It names tables and pictures.
    pub name: String,
    /// One a size.
    pub scenes: Vec<SceneSpec>,
    /// Methods in the order of the tables.
    pub methods: Vec<MethodName>,
    /// Numbers of worker threads; each method runs with each.
    pub threads: Vec<usize>,
    /// `--memory` of every run, bytes.
    pub memory_limit_bytes: u64,
    /// Rounds, in each of which every method runs once.
    pub repeats: usize,
    /// A run that takes longer is stopped, seconds.
    pub time_limit_s: f64,
    /// Whether copying and reading of the same files are measured beside.
    pub references: bool,
}

/// One made scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneSpec {
    /// Holes and cells.
    pub preset: Preset,
    /// Columns and rows; the preset's own if `None`.
    pub cells: Option<[i64; 2]>,
    /// Triangles a cell, about.
    pub triangles: u64,
    /// Seed of everything random.
    pub seed: u64,
    /// Format of the tiles.
    pub format: Format,
}

impl SceneSpec {
    /// Name of its folder: every field stands in it.
    #[must_use]
    pub fn folder_name(&self) -> String {
        let cells = self.cells.map_or_else(|| "own".to_owned(), |[c, r]| format!("{c}x{r}"));
        let (preset, format) = (word(self.preset), word(self.format));
        format!("{preset}_{cells}_{}_{format}_{}", self.triangles, self.seed)
    }
}

/// The word of a value on the command line of the scene tool.
fn word(value: impl ValueEnum) -> String {
    value.to_possible_value().map_or_else(String::new, |v| v.get_name().to_owned())
}

impl BenchConfig {
    /// Reads a file; shares of memory and 0 threads become those of the machine.
    ///
    /// # Errors
    /// A file that cannot be read or understood, with the place; a series without a usable name or without scenes.
    pub fn read(path: &Path, machine: &Machine) -> Result<Self, ConfigError> {
        let text = std::fs::read_to_string(path)
            .map_err(|source| ConfigError::Read { path: path.to_owned(), source })?;
        Self::parse(&text, path, machine)
    }

    /// Reads a text; `path` stands in the errors.
    ///
    /// # Errors
    /// As [`BenchConfig::read`].
    pub fn parse(text: &str, path: &Path, machine: &Machine) -> Result<Self, ConfigError> {
        let file: FileSection = parse_ron(text, path, &KEYS)?;
        let problem = |what: String| ConfigError::Settings(format!("{}: {what}", path.display()));
        let series: Vec<Series> = file.series.iter().map(|s| resolve(s, &file.run, machine)).collect();
        if series.is_empty() {
            return Err(problem("`series` is empty; give at least one (name: .., preset: ..)".to_owned()));
        }
        for (k, one) in series.iter().enumerate() {
            let shown = one.name.escape_debug();
            if !is_good_name(&one.name) {
                let rule = "letters, digits, - and _ make a name, for it names files";
                return Err(problem(format!("series `{shown}`: {rule}")));
            }
            if series[..k].iter().any(|other| other.name == one.name) {
                return Err(problem(format!("series `{shown}` stands there twice; rename one")));
            }
        }
        Ok(Self { series })
    }
}

fn is_good_name(name: &str) -> bool {
    !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_')
}

fn resolve(own: &SeriesSection, run: &RunSection, machine: &Machine) -> Series {
    let sizes: Vec<Option<[i64; 2]>> = match &own.cells {
        Some(sizes) => sizes.iter().map(|&(columns, rows)| Some([columns, rows])).collect(),
        None => vec![None],
    };
    let triangles = own.triangles.unwrap_or_else(|| own.preset.default_triangles());
    let scene = |cells| SceneSpec {
        preset: own.preset,
        cells,
        triangles,
        seed: own.seed.unwrap_or(1),
        format: own.format.unwrap_or(Format::Ply),
    };
    let all = || vec![MethodName::Field, MethodName::Layered, MethodName::Aggregate];
    let threads = own.threads.clone().or_else(|| run.threads.clone()).unwrap_or_else(|| vec![0]);
    Series {
        name: own.name.clone(),
        scenes: sizes.into_iter().map(scene).collect(),
        methods: own.methods.clone().or_else(|| run.methods.clone()).unwrap_or_else(all),
        threads: threads.into_iter().map(|n| if n == 0 { machine.threads } else { n }).collect(),
        memory_limit_bytes: own.memory.or(run.memory).unwrap_or(MemoryLimit::DEFAULT).bytes_on(machine),
        repeats: own.repeats.or(run.repeats).unwrap_or(3),
        time_limit_s: own.time_limit_s.or(run.time_limit_s).unwrap_or(3600.0),
        references: own.references.or(run.references).unwrap_or(true),
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct FileSection {
    #[serde(deserialize_with = "version_one")]
    #[expect(dead_code, reason = "checked while it is read")]
    version: u32,
    #[serde(default)]
    run: RunSection,
    series: Vec<SeriesSection>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct RunSection {
    #[serde(deserialize_with = "some_of_them")]
    methods: Option<Vec<MethodName>>,
    #[serde(deserialize_with = "some_of_them")]
    threads: Option<Vec<usize>>,
    memory: Option<MemoryLimit>,
    #[serde(deserialize_with = "at_least_once")]
    repeats: Option<usize>,
    #[serde(deserialize_with = "some_time")]
    time_limit_s: Option<f64>,
    references: Option<bool>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SeriesSection {
    name: String,
    preset: Preset,
    #[serde(default, deserialize_with = "some_of_them")]
    cells: Option<Vec<(i64, i64)>>,
    #[serde(default)]
    triangles: Option<u64>,
    #[serde(default)]
    seed: Option<u64>,
    #[serde(default)]
    format: Option<Format>,
    #[serde(default, deserialize_with = "some_of_them")]
    methods: Option<Vec<MethodName>>,
    #[serde(default, deserialize_with = "some_of_them")]
    threads: Option<Vec<usize>>,
    #[serde(default)]
    memory: Option<MemoryLimit>,
    #[serde(default, deserialize_with = "at_least_once")]
    repeats: Option<usize>,
    #[serde(default, deserialize_with = "some_time")]
    time_limit_s: Option<f64>,
    #[serde(default)]
    references: Option<bool>,
}

/// The keys, with what stands behind each.
const KEYS: [Key; 16] = [
    key("", "version", "the number 1"),
    key("", "run", "a section such as (methods: [field, aggregate], memory: \"2GiB\", repeats: 3)"),
    key("", "series", "a list such as [(name: \"growing\", preset: growing, cells: [(4, 2), (8, 4)])]"),
    key("run", "methods", "a list of field, layered, aggregate"),
    key("run", "threads", "a list of counts such as [1, 2], 0 = one a processor"),
    key("run", "memory", "a size in quotes, such as \"12GiB\", \"512MiB\" or \"50%\""),
    key("run", "repeats", "a count from 1, such as 3"),
    key("run", "time_limit_s", "a time in seconds, such as 600"),
    key("run", "references", "true or false"),
    key("series", "name", "a name in quotes"),
    key("series", "preset", "small, demo, city, a, b, b_added or growing"),
    key("series", "cells", "a list of columns and rows, such as [(4, 2), (8, 4)]"),
    key("series", "triangles", "a count a cell, such as 100_000"),
    key("series", "seed", "a whole number, such as 1"),
    key("series", "format", "ply, ply_double, ply_ascii, obj or glb"),
    key("series", "methods", "a list of field, layered, aggregate"),
];

fn some_of_them<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<Vec<T>>, D::Error> {
    match Option::<Vec<T>>::deserialize(deserializer)? {
        Some(list) if list.is_empty() => Err(D::Error::custom("give at least one, or leave it out")),
        other => Ok(other),
    }
}

fn at_least_once<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<usize>, D::Error> {
    match Option::<usize>::deserialize(deserializer)? {
        Some(0) => Err(D::Error::custom("must be at least 1")),
        other => Ok(other),
    }
}

fn some_time<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    match Option::<f64>::deserialize(deserializer)? {
        // A day is more than anybody waits for one run, and a duration holds it.
        Some(seconds) if !(seconds > 0.0 && seconds <= 86_400.0) => {
            Err(D::Error::custom("must be above 0 and at most 86400"))
        }
        other => Ok(other),
    }
}
