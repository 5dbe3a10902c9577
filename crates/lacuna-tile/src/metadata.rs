//! Where a scene's coordinates begin: `metadata.xml` of iTwin Capture, `coords.txt` of OpenDroneMap.

use std::io::Read as _;
use std::path::{Path, PathBuf};

/// Largest metadata file that is read, bytes.
const MAX_BYTES: u64 = 1 << 20;
/// Most XML nodes that are read; a `metadata.xml` has about twenty.
const MAX_XML_NODES: u32 = 10_000;
/// Folders above the scene that are looked at.
const LEVELS_UP: usize = 2;

/// Which producer's file a scene's origin comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MetadataKind {
    /// `metadata.xml` of iTwin Capture (ContextCapture): `xyz in the SRS = xyz in the file + origin`.
    ItwinCapture,
    /// `coords.txt` of OpenDroneMap: east and north were subtracted from x and y, z is absolute.
    OpenDroneMap,
}

/// Spatial reference of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneMetadata {
    /// File it comes from, relative to the scene's folder (`metadata.xml`, `../metadata.xml`).
    pub source: String,
    /// Spatial reference system as written: `EPSG:4549`, `ENU:35.76,-120.77` (latitude first), WKT, `WGS84 UTM 17N`.
    pub srs: Option<String>,
    /// Added to file coordinates this gives SRS coordinates, metres: east, north, up.
    pub srs_origin: [f64; 3],
    /// Producer.
    pub kind: MetadataKind,
}

/// What the search for metadata found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MetadataSearch {
    /// The nearest file that could be read.
    pub found: Option<SceneMetadata>,
    /// Paths that were tried, relative to the scene's folder, in order, up to the one found.
    pub tried: Vec<String>,
    /// What was missing or odd.
    pub warnings: Vec<String>,
}

/// A metadata file that is there and cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum MetadataError {
    /// The file could not be read.
    #[error("{}: cannot read the scene's metadata: {source}; make the file readable or move it away", path.display().to_string().escape_debug())]
    Io {
        /// The file.
        path: PathBuf,
        /// Cause.
        source: std::io::Error,
    },
    /// The file holds something else than it should.
    #[error("{}: {problem}; correct the file, or move it away and give --srs and --srs-origin", path.display().to_string().escape_debug())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// What is wrong, with line and column where known.
        problem: String,
    },
}

/// Looks for metadata in the scene's folder and up to two folders above it; the nearest file wins.
///
/// In each folder `metadata.xml`, `coords.txt` and `odm_georeferencing/coords.txt` are tried in this order. No file at
/// all is no error: a scene needs no reference system to be repaired. An XML file that is no `ModelMetadata` is passed
/// over with a warning.
///
/// # Errors
/// A file with the right name that is unreadable, larger than 1 MiB, not UTF-8, or malformed.
pub fn find_metadata(root: &Path) -> Result<MetadataSearch, MetadataError> {
    let mut search = MetadataSearch::default();
    for up in 0..=LEVELS_UP {
        let above = "../".repeat(up);
        for name in ["metadata.xml", "coords.txt", "odm_georeferencing/coords.txt"] {
            let relative = format!("{above}{name}");
            let path = root.join(&relative);
            search.tried.push(relative.clone());
            let Some(text) = read_text(&path)? else { continue };
            let parsed = if name == "metadata.xml" {
                parse_model_metadata(&text, &relative, &mut search.warnings)
            } else {
                parse_coords(&text, &relative, &mut search.warnings)
            };
            search.found = parsed.map_err(|problem| MetadataError::Malformed { path, problem })?;
            if search.found.is_some() {
                return Ok(search);
            }
        }
    }
    Ok(search)
}

/// The file's text without a byte order mark; `None` if there is no such file.
fn read_text(path: &Path) -> Result<Option<String>, MetadataError> {
    let io = |source| MetadataError::Io { path: path.to_owned(), source };
    let malformed = |problem: String| MetadataError::Malformed { path: path.to_owned(), problem };
    match std::fs::metadata(path) {
        Ok(found) if found.is_file() => {}
        // Folders, pipes and devices of that name are not metadata and are never opened.
        Ok(_) => return Ok(None),
        Err(e) if is_absent(&e) => return Ok(None),
        Err(e) => return Err(io(e)),
    }
    let mut bytes = Vec::new();
    let file = std::fs::File::open(path).map_err(io)?;
    file.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(io)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(malformed(format!("the file is larger than {MAX_BYTES} bytes")));
    }
    let text = String::from_utf8(bytes)
        .map_err(|e| malformed(format!("byte {} is not UTF-8", e.utf8_error().valid_up_to())))?;
    Ok(Some(text.strip_prefix('\u{feff}').unwrap_or(&text).to_owned()))
}

fn is_absent(error: &std::io::Error) -> bool {
    matches!(error.kind(), std::io::ErrorKind::NotFound | std::io::ErrorKind::NotADirectory)
}

/// Reads `<ModelMetadata>`; `Ok(None)` with a warning if the root element is another.
fn parse_model_metadata(
    text: &str,
    relative: &str,
    warnings: &mut Vec<String>,
) -> Result<Option<SceneMetadata>, String> {
    let options = roxmltree::ParsingOptions { nodes_limit: MAX_XML_NODES, ..Default::default() };
    let document = roxmltree::Document::parse_with_options(text, options)
        .map_err(|e| format!("not readable as XML: {e}"))?;
    let root = document.root_element();
    if root.tag_name().name() != "ModelMetadata" {
        let found = root.tag_name().name().escape_debug();
        warnings.push(format!("{relative}: the root element is <{found}>, not <ModelMetadata>: passed over"));
        return Ok(None);
    }
    let text_of = |name: &str| {
        let child = root.children().find(|c| c.tag_name().name() == name)?;
        let text: String =
            child.descendants().filter(roxmltree::Node::is_text).filter_map(|n| n.text()).collect();
        Some(text.trim().to_owned()).filter(|t| !t.is_empty())
    };
    let srs = text_of("SRS");
    if srs.is_none() {
        warnings.push(format!(
            "{relative}: no SRS: coordinates stay without a reference system (--srs gives one)"
        ));
    }
    let srs_origin = match text_of("SRSOrigin") {
        Some(written) => parse_origin(&written)?,
        None => {
            warnings.push(format!("{relative}: no SRSOrigin: 0,0,0 taken (--srs-origin overrides it)"));
            [0.0; 3]
        }
    };
    Ok(Some(SceneMetadata { source: relative.to_owned(), srs, srs_origin, kind: MetadataKind::ItwinCapture }))
}

/// `east,north,up`, with or without spaces.
fn parse_origin(written: &str) -> Result<[f64; 3], String> {
    let refused = || format!("SRSOrigin is {:?}, not three numbers x,y,z", shorten(written));
    let numbers: Vec<f64> = written
        .split(|c: char| c == ',' || c.is_whitespace())
        .filter(|part| !part.is_empty())
        .map(|part| part.parse().ok().filter(|n: &f64| n.is_finite()))
        .collect::<Option<_>>()
        .ok_or_else(refused)?;
    <[f64; 3]>::try_from(numbers).map_err(|_| refused())
}

/// Reads OpenDroneMap's `coords.txt`: the reference system, then east and north of the local origin.
///
/// `Ok(None)` with a warning if the first line names no reference system: many programs write a `coords.txt`.
fn parse_coords(
    text: &str,
    relative: &str,
    warnings: &mut Vec<String>,
) -> Result<Option<SceneMetadata>, String> {
    let mut lines = text.lines().map(str::trim);
    let srs = lines.next().unwrap_or("");
    if !(srs.starts_with("WGS84 UTM") || srs.starts_with("+proj") || srs.starts_with("EPSG:")) {
        warnings.push(format!(
            "{relative}: line 1 is {:?}, not a reference system as OpenDroneMap writes it: passed over",
            shorten(srs)
        ));
        return Ok(None);
    }
    let second = lines.next().unwrap_or("");
    let numbers: Vec<f64> = second.split_whitespace().map_while(|part| part.parse().ok()).collect();
    let [east, north] = numbers[..] else {
        return Err(format!("line 2 is {:?}, not `<east> <north>`", shorten(second)));
    };
    if !(east.is_finite() && north.is_finite()) {
        return Err("line 2 holds a number that is not finite".to_owned());
    }
    Ok(Some(SceneMetadata {
        source: relative.to_owned(),
        srs: Some(srs.to_owned()),
        srs_origin: [east, north, 0.0],
        kind: MetadataKind::OpenDroneMap,
    }))
}

/// The beginning of a text that stands in a file, for a message.
fn shorten(text: &str) -> String {
    text.chars().take(60).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn xml(body: &str) -> String {
        format!(
            "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<ModelMetadata version=\"1\">{body}</ModelMetadata>"
        )
    }

    /// One line that says what came out.
    fn outcome(parsed: Result<Option<SceneMetadata>, String>, warnings: &[String]) -> String {
        match parsed {
            Ok(Some(m)) => format!("{} {:?} w{}", m.srs.unwrap_or_default(), m.srs_origin, warnings.len()),
            Ok(None) => format!("passed over w{}", warnings.len()),
            Err(problem) => format!("error: {problem}"),
        }
    }

    #[test]
    fn model_metadata_dialects() {
        let cases = [
            ("<SRS>EPSG:4549</SRS><SRSOrigin>1.5,2,-3</SRSOrigin>", "EPSG:4549 [1.5, 2.0, -3.0] w0"),
            ("<SRS>EPSG:4549+5773</SRS><SRSOrigin>1, 2, 3</SRSOrigin>", "EPSG:4549+5773 [1.0, 2.0, 3.0] w0"),
            (
                "<SRS>\n ENU:28.1,112.9 \n</SRS><SRSOrigin>\n-444,-510,28\n</SRSOrigin>",
                "ENU:28.1,112.9 [-444.0, -510.0, 28.0] w0",
            ),
            ("<SRS>LOCAL</SRS>", "LOCAL [0.0, 0.0, 0.0] w1"),
            ("", " [0.0, 0.0, 0.0] w2"),
            ("<SRS>A<!-- c -->B</SRS><SRSOrigin>0,0,0</SRSOrigin><Texture/>", "AB [0.0, 0.0, 0.0] w0"),
            ("<SRSOrigin>1,2</SRSOrigin>", "error: SRSOrigin is \"1,2\", not three numbers x,y,z"),
            ("<SRSOrigin>1,2,nan</SRSOrigin>", "error: SRSOrigin is \"1,2,nan\", not three numbers x,y,z"),
            (
                "<SRSOrigin>1,2,1e999</SRSOrigin>",
                "error: SRSOrigin is \"1,2,1e999\", not three numbers x,y,z",
            ),
        ];
        for (body, expected) in cases {
            let mut warnings = Vec::new();
            let parsed = parse_model_metadata(&xml(body), "metadata.xml", &mut warnings);
            assert_eq!(outcome(parsed, &warnings), expected, "body {body}");
        }
    }

    #[test]
    fn hostile_xml_is_an_error_or_passed_over() {
        let bomb =
            "<!DOCTYPE a [<!ENTITY b \"bb\"><!ENTITY c \"&b;&b;\">]><ModelMetadata>&c;</ModelMetadata>";
        let many = xml(&"<a/>".repeat(20_000));
        let deep = format!("{}{}", "<a>".repeat(5_000), "</a>".repeat(5_000));
        for (name, text) in [("entities", bomb), ("nodes", &many), ("half a file", "<ModelMetadata><SRS>")] {
            let mut warnings = Vec::new();
            assert!(parse_model_metadata(text, "metadata.xml", &mut warnings).is_err(), "{name}");
        }
        for (name, text) in [("another root", "<MD_Metadata/>"), ("deep", &deep)] {
            let mut warnings = Vec::new();
            let parsed = parse_model_metadata(text, "metadata.xml", &mut warnings);
            assert!(!matches!(parsed, Ok(Some(_))), "{name}");
        }
    }

    #[test]
    fn coords_dialects() {
        let cases = [
            ("WGS84 UTM 17N\n529000 5020000\n1 2 3\n", "WGS84 UTM 17N [529000.0, 5020000.0, 0.0] w0"),
            ("WGS84 UTM 17N\r\n529000 5020000\r\n", "WGS84 UTM 17N [529000.0, 5020000.0, 0.0] w0"),
            ("+proj=utm +zone=17\n1.5 -2.5", "+proj=utm +zone=17 [1.5, -2.5, 0.0] w0"),
            ("1 2 3\n4 5 6\n", "passed over w1"),
            ("", "passed over w1"),
            ("WGS84 UTM 17N\n1\n", "error: line 2 is \"1\", not `<east> <north>`"),
            ("WGS84 UTM 17N\n1 inf\n", "error: line 2 holds a number that is not finite"),
        ];
        for (text, expected) in cases {
            let mut warnings = Vec::new();
            let parsed = parse_coords(text, "coords.txt", &mut warnings);
            assert_eq!(outcome(parsed, &warnings), expected, "text {text:?}");
        }
    }

    #[test]
    fn the_nearest_file_wins_and_tried_paths_are_named() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let root = folder.path().join("a/Data");
        std::fs::create_dir_all(&root).expect("folder");
        let write = |path: &Path, srs: &str| {
            let text = xml(&format!("<SRS>{srs}</SRS><SRSOrigin>0,0,0</SRSOrigin>"));
            std::fs::write(path, text).expect("write");
        };
        assert_eq!(find_metadata(&root).expect("search").found, None);
        write(&folder.path().join("metadata.xml"), "far");
        let far = find_metadata(&root).expect("search");
        assert_eq!(
            far.found.map(|m| (m.source, m.srs)),
            Some(("../../metadata.xml".into(), Some("far".into())))
        );
        assert_eq!(far.tried.len(), 7);
        write(&root.join("metadata.xml"), "near");
        let near = find_metadata(&root).expect("search");
        assert_eq!(near.found.and_then(|m| m.srs), Some("near".into()));
        assert_eq!(near.tried, ["metadata.xml"]);
    }

    #[test]
    fn unusable_files_are_named_errors() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("metadata.xml");
        let large = vec![b' '; MAX_BYTES as usize + 1];
        for (content, word) in [(&b"\xff\xfe<\0"[..], "UTF-8"), (&large, "larger"), (b"<a", "XML")] {
            std::fs::write(&path, content).expect("write");
            let message = find_metadata(folder.path()).expect_err("refused").to_string();
            assert!(message.contains(word) && message.contains("metadata.xml"), "{message}");
        }
    }

    #[test]
    fn a_byte_order_mark_is_no_obstacle() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let text = format!("\u{feff}{}", xml("<SRS>EPSG:1</SRS><SRSOrigin>1,2,3</SRSOrigin>"));
        std::fs::write(folder.path().join("metadata.xml"), text).expect("write");
        let found = find_metadata(folder.path()).expect("search").found;
        assert_eq!(found.map(|m| m.srs_origin), Some([1.0, 2.0, 3.0]));
    }
}
