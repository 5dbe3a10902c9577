//! The configuration file (RON): what stands in it, and errors that show the place.

use super::error::{ConfigError, FileError};
use super::keys::{self, Key};
use super::memory::MemoryLimit;
use super::settings::{
    ClosedFiller, External, FailOn, HoleClassFilter, HoleShapeFilter, MethodName, OpenFiller, Untouched,
    UpAxis,
};
use super::water::{WaterIslands, WaterMode};
use ron::error::{Error, SpannedError};
use ron::extensions::Extensions;
use serde::de::{DeserializeOwned, Error as _};
use serde::{Deserialize, Deserializer};
use std::fs;
use std::path::{Path, PathBuf};

/// The whole file; every key but `version` may be left out.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ConfigFile {
    #[serde(deserialize_with = "version_one")]
    #[expect(dead_code, reason = "checked while it is read")]
    version: u32,
    #[serde(default)]
    pub(crate) scene: SceneSection,
    #[serde(default)]
    pub(crate) area: AreaSection,
    #[serde(default)]
    pub(crate) run: RunSection,
    #[serde(default)]
    pub(crate) find: FindSection,
    #[serde(default)]
    pub(crate) fill: FillSection,
    #[serde(default)]
    pub(crate) field: FieldSection,
    #[serde(default)]
    pub(crate) water: WaterSection,
    #[serde(default)]
    pub(crate) regions: Vec<RegionSection>,
}

/// `scene`.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct SceneSection {
    pub(crate) input: Option<PathBuf>,
    pub(crate) output: Option<PathBuf>,
    pub(crate) untouched: Option<Untouched>,
    #[serde(deserialize_with = "positive")]
    pub(crate) cell_size_m: Option<f64>,
    pub(crate) cell_origin_m: Option<(f64, f64)>,
    pub(crate) up_axis: Option<UpAxis>,
    pub(crate) srs: Option<String>,
    pub(crate) srs_origin: Option<(f64, f64, f64)>,
}

/// `area`.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct AreaSection {
    pub(crate) limit: Option<LimitWord>,
    pub(crate) external: Option<External>,
}

/// `area.limit`.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum LimitWord {
    Cells,
    Box,
    Polygon(PathBuf),
}

/// `run`.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct RunSection {
    pub(crate) memory: Option<MemoryLimit>,
    pub(crate) threads: Option<usize>,
    pub(crate) fail_on: Option<FailOn>,
}

/// `find`.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct FindSection {
    #[serde(deserialize_with = "not_negative")]
    pub(crate) min_area_m2: Option<f64>,
    #[serde(deserialize_with = "positive")]
    pub(crate) max_area_m2: Option<f64>,
    #[serde(deserialize_with = "positive")]
    pub(crate) max_perimeter_m: Option<f64>,
    pub(crate) max_edges_around_hole: Option<u64>,
    pub(crate) class: Option<Vec<HoleClassFilter>>,
    pub(crate) shape: Option<Vec<HoleShapeFilter>>,
}

/// `fill`, of the scene or of a region.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct FillSection {
    pub(crate) method: Option<MethodName>,
    pub(crate) closed: Option<ClosedFiller>,
    pub(crate) open: Option<OpenFiller>,
    #[serde(deserialize_with = "positive")]
    pub(crate) spacing_m: Option<f64>,
}

/// `field`.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct FieldSection {
    #[serde(deserialize_with = "enough_unknowns")]
    pub(crate) max_unknowns: Option<usize>,
}

/// `water`.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct WaterSection {
    #[serde(deserialize_with = "finite_level")]
    pub(crate) mode: Option<WaterMode>,
    pub(crate) polygons: Option<PathBuf>,
    #[serde(deserialize_with = "positive_area")]
    pub(crate) islands: Option<WaterIslands>,
}

/// One of `regions`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RegionSection {
    pub(crate) name: String,
    pub(crate) at: PlaceWord,
    #[serde(default)]
    pub(crate) skip: Option<String>,
    #[serde(default)]
    pub(crate) fill: FillSection,
    #[serde(default, deserialize_with = "finite_level")]
    pub(crate) water: Option<WaterMode>,
}

/// `regions[..].at`.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum PlaceWord {
    Point(f64, f64),
    Box(f64, f64, f64, f64),
    Polygon(PathBuf),
}

impl ConfigFile {
    /// Reads a file.
    ///
    /// # Errors
    /// A file that cannot be read; RON that is wrong; unknown keys and wrong values, with the place.
    pub(crate) fn read(path: &Path) -> Result<Self, ConfigError> {
        let text =
            fs::read_to_string(path).map_err(|source| ConfigError::Read { path: path.to_owned(), source })?;
        Self::parse(&text, path).map_err(ConfigError::from)
    }

    /// Reads a text; `path` stands in the errors.
    pub(crate) fn parse(text: &str, path: &Path) -> Result<Self, FileError> {
        parse_ron(text, path, &keys::KEYS)
    }
}

/// Reads RON of any kind; `path` stands in the errors, `keys` are all keys that the file may hold.
///
/// # Errors
/// RON that is wrong; unknown keys and wrong values, with the place.
pub(crate) fn parse_ron<T: DeserializeOwned>(text: &str, path: &Path, keys: &[Key]) -> Result<T, FileError> {
    let options = ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME);
    options.from_str(text).map_err(|error| explain(text, path, keys, &error))
}

pub(crate) fn version_one<'de, D: Deserializer<'de>>(deserializer: D) -> Result<u32, D::Error> {
    match u32::deserialize(deserializer)? {
        1 => Ok(1),
        other => Err(D::Error::custom(format!(
            "version {other} is unknown; this version of lacuna reads version 1"
        ))),
    }
}

/// Fewer and there is no shape left to fit.
const LEAST_UNKNOWNS: usize = 1000;

fn enough_unknowns<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<usize>, D::Error> {
    match Option::<usize>::deserialize(deserializer)? {
        Some(count) if count < LEAST_UNKNOWNS => {
            Err(D::Error::custom(format!("must be at least {LEAST_UNKNOWNS}")))
        }
        other => Ok(other),
    }
}

fn finite_level<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<WaterMode>, D::Error> {
    match Option::<WaterMode>::deserialize(deserializer)? {
        Some(mode) if !mode.is_finite() => Err(D::Error::custom("a level must be a finite number")),
        other => Ok(other),
    }
}

fn positive_area<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<WaterIslands>, D::Error> {
    match Option::<WaterIslands>::deserialize(deserializer)? {
        Some(WaterIslands::Under { max_area_m2 }) if !(max_area_m2.is_finite() && max_area_m2 > 0.0) => {
            Err(D::Error::custom("must be above 0"))
        }
        other => Ok(other),
    }
}

fn positive<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    checked(deserializer, |v| v > 0.0, "must be above 0")
}

fn not_negative<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    checked(deserializer, |v| v >= 0.0, "must not be negative")
}

fn checked<'de, D: Deserializer<'de>>(
    deserializer: D,
    is_good: fn(f64) -> bool,
    rule: &str,
) -> Result<Option<f64>, D::Error> {
    match Option::<f64>::deserialize(deserializer)? {
        Some(value) if !(value.is_finite() && is_good(value)) => Err(D::Error::custom(rule)),
        other => Ok(other),
    }
}

/// Turns the parser's error into one with the line, a caret, and what the key takes.
fn explain(text: &str, path: &Path, keys: &[Key], error: &SpannedError) -> FileError {
    let place = Place::of(text, error);
    let (what, help) = match &error.code {
        Error::NoSuchStructField { expected, found, .. } => {
            (format!("unknown key `{}`", found.escape_debug()), Some(keys::advice(keys, found, expected)))
        }
        Error::MissingStructField { field, .. } => {
            (format!("`{field}` is missing"), keys::meaning(keys, field).map(|m| format!("`{field}` is {m}")))
        }
        Error::DuplicateStructField { field, .. } => (format!("`{field}` stands here twice"), None),
        Error::NoSuchEnumVariant { found, .. } => {
            (format!("unknown word `{}`", found.escape_debug()), place.key_help(keys))
        }
        Error::Message(message) => (place.named(message), place.key_help(keys)),
        Error::ExpectedFloat | Error::ExpectedInteger => {
            (place.named("expected a number, without quotes and without a unit"), place.key_help(keys))
        }
        Error::ExpectedString => (place.named("expected a text in quotes"), place.key_help(keys)),
        Error::ExpectedStructLike | Error::ExpectedNamedStructLike(_) => {
            let help = "a section stands in parentheses; the least file is (version: 1)";
            ("expected an opening parenthesis".to_owned(), Some(help.to_owned()))
        }
        Error::ExpectedComma if place.is_number_with_unit() => {
            (place.named("a number stands alone; its unit is in the key's name"), place.key_help(keys))
        }
        Error::ExpectedComma | Error::ExpectedStructLikeEnd | Error::Eof => {
            ("expected a comma or a closing parenthesis".to_owned(), None)
        }
        Error::InvalidIdentifier(found) | Error::SuggestRawIdentifier(found) => {
            (format!("expected a key, found `{}`", found.escape_debug()), None)
        }
        Error::TrailingCharacters => ("nothing may stand behind the last parenthesis".to_owned(), None),
        other => (place.named(&lower_first(&other.to_string())), place.key_help(keys)),
    };
    FileError {
        path: path.to_owned(),
        line: place.line,
        column: place.column,
        width: place.width,
        source_line: place.source_line,
        what,
        help,
    }
}

fn lower_first(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |first| first.to_lowercase().chain(chars).collect())
}

/// Where an error lies.
struct Place {
    line: usize,
    column: usize,
    width: usize,
    source_line: String,
    /// The key whose value it is, if there is one on the line.
    key: Option<String>,
}

impl Place {
    fn of(text: &str, error: &SpannedError) -> Self {
        let line = error.span.start.line.max(1);
        let source_line = text.lines().nth(line - 1).unwrap_or_default().to_owned();
        let chars: Vec<char> = source_line.chars().collect();
        let at = error.span.start.col.saturating_sub(1).min(chars.len());
        let (from, to) = match &error.code {
            Error::NoSuchStructField { found, .. } => word_near(&chars, at, found),
            // The parser may stand on the key of the value that it did not like.
            _ => {
                let stretch = value_near(&chars, at);
                behind_key(&chars, stretch).unwrap_or(stretch)
            }
        };
        let is_key = chars.get(to) == Some(&':');
        let key = if is_key { Some(chars[from..to].iter().collect()) } else { key_before(&chars[..from]) };
        Self { line, column: from + 1, width: (to - from).max(1), source_line, key }
    }

    /// True for `250m`: digits first, a letter last.
    fn is_number_with_unit(&self) -> bool {
        let mut value = self.source_line.chars().skip(self.column - 1).take(self.width);
        value.next().is_some_and(|c| c.is_ascii_digit()) && value.last().is_some_and(char::is_alphabetic)
    }

    fn named(&self, message: &str) -> String {
        self.key.as_ref().map_or_else(|| message.to_owned(), |key| format!("`{key}`: {message}"))
    }

    fn key_help(&self, keys: &[Key]) -> Option<String> {
        let key = self.key.as_ref()?;
        keys::meaning(keys, key).map(|meaning| format!("`{key}` takes {meaning}"))
    }
}

/// The occurrence of a word that ends nearest to `at`.
fn word_near(chars: &[char], at: usize, word: &str) -> (usize, usize) {
    let word: Vec<char> = word.chars().collect();
    let starts = (0..(chars.len() + 1).saturating_sub(word.len())).filter(|&s| chars[s..].starts_with(&word));
    let best = starts.min_by_key(|&s| (s + word.len()).abs_diff(at));
    best.map_or((at, at), |s| (s, s + word.len()))
}

/// The value round or just before `at`: from the `:` , `(` or `[` before it to the `,` `)` `]` or blank behind it.
fn value_near(chars: &[char], at: usize) -> (usize, usize) {
    let is_end = |c: char| matches!(c, ',' | '(' | ')' | '[' | ']' | ':');
    let mut from = at;
    // The parser may stand behind the value that it did not like.
    while from > 0 && (from == chars.len() || is_end(chars[from]) || chars[from].is_whitespace()) {
        from -= 1;
        if from < chars.len() && !is_end(chars[from]) && !chars[from].is_whitespace() {
            break;
        }
    }
    let quoted = chars[..from.min(chars.len())].iter().filter(|c| **c == '"').count() % 2 == 1;
    let stop = |c: char| if quoted { c == '"' } else { is_end(c) || c.is_whitespace() };
    while from > 0 && !stop(chars[from - 1]) {
        from -= 1;
    }
    if quoted {
        from -= 1;
    }
    (from, end_of_value(chars, from))
}

/// If a stretch is a key with its colon, the value behind it on the same line, else the key without the colon.
fn behind_key(chars: &[char], (from, to): (usize, usize)) -> Option<(usize, usize)> {
    let colon = chars.get(from..to)?.iter().position(|c| *c == ':')? + from;
    let value = colon + 1 + chars[colon + 1..].iter().take_while(|c| c.is_whitespace()).count();
    Some(if value < chars.len() { (value, end_of_value(chars, value)) } else { (from, colon) })
}

fn end_of_value(chars: &[char], from: usize) -> usize {
    let rest = &chars[from.min(chars.len())..];
    let length = match rest.first() {
        Some('"') => rest.iter().skip(1).position(|c| *c == '"').map_or(rest.len(), |p| p + 2),
        _ => rest
            .iter()
            .position(|c| matches!(c, ',' | '(' | ')' | '[' | ']') || c.is_whitespace())
            .unwrap_or(rest.len()),
    };
    from + length
}

/// The last `key:` before a value, unless a comma on the same level lies between (then the value has no key).
fn key_before(chars: &[char]) -> Option<String> {
    let colon = chars.iter().rposition(|c| *c == ':')?;
    let is_name = |c: &char| c.is_alphanumeric() || *c == '_';
    let end = chars[..colon].iter().rposition(is_name)? + 1;
    let start = chars[..end].iter().rposition(|c| !is_name(c)).map_or(0, |p| p + 1);
    Some(chars[start..end].iter().collect())
}
