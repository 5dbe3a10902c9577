//! The keys of the configuration file: section, name, and what stands behind the colon.

/// One key.
#[derive(Debug)]
pub(crate) struct Key {
    /// `scene`, `find` ...; empty for the outermost level.
    pub(crate) section: &'static str,
    /// The key.
    pub(crate) name: &'static str,
    /// What it takes, with the unit and an example.
    pub(crate) meaning: &'static str,
}

pub(crate) const fn key(section: &'static str, name: &'static str, meaning: &'static str) -> Key {
    Key { section, name, meaning }
}

/// All keys of this version.
pub(crate) const KEYS: [Key; 44] = [
    key("", "version", "the number 1"),
    key("", "scene", "a section such as (input: \"tiles\", output: \"out\")"),
    key("", "area", "a section such as (limit: cells, external: skip)"),
    key("", "run", "a section such as (memory: \"50%\", threads: 0)"),
    key("", "find", "a section such as (min_area_m2: 0.5)"),
    key("", "fill", "a section such as (method: field)"),
    key("", "field", "a section such as (max_unknowns: 400_000)"),
    key("", "water", "a section such as (mode: auto)"),
    key("", "regions", "a list such as [(name: \"quay\", at: point(84512, 447233), skip: \"why\")]"),
    key("scene", "input", "a folder in quotes"),
    key("scene", "output", "a folder in quotes"),
    key("scene", "untouched", "copy, reflink or omit"),
    key("scene", "cell_size_m", "a length in metres, such as 250.0"),
    key("scene", "cell_origin_m", "a corner of the grid in metres, such as (84000.0, 446000.0)"),
    key("scene", "up_axis", "y or z"),
    key("scene", "srs", "a reference system in quotes, such as \"EPSG:28992\""),
    key("scene", "srs_origin", "three numbers in metres, such as (84000.0, 446000.0, 0.0)"),
    key("area", "limit", "cells, box or polygon(\"file.geojson\")"),
    key("area", "external", "skip or fill"),
    key("run", "memory", "a size in quotes, such as \"12GiB\", \"512MiB\" or \"50%\""),
    key("run", "threads", "a count, 0 = one a processor"),
    key("run", "fail_on", "tiles, holes or never"),
    key("find", "min_area_m2", "an area in square metres, such as 0.5"),
    key("find", "max_area_m2", "an area in square metres, such as 400_000"),
    key("find", "max_perimeter_m", "a length in metres, such as 2500.0"),
    key("find", "max_edges_around_hole", "a count of edges, such as 5000"),
    key("find", "class", "a list of closed, I, II"),
    key("find", "shape", "a list of A, B, C, D"),
    key("fill", "method", "field, layered or aggregate"),
    key("fill", "closed", "auto, delaunay or min_area"),
    key("fill", "open", "auto or delaunay"),
    key("fill", "spacing_m", "a length in metres, such as 0.5"),
    key("field", "max_unknowns", "a count of vertices, at least 1000, such as 400_000"),
    key("water", "mode", WATER),
    key("water", "polygons", "a GeoJSON file in quotes, such as \"gis/water.geojson\""),
    key(
        "water",
        "islands",
        "join, or under(max_area_m2: area in square metres), such as under(max_area_m2: 400)",
    ),
    key("sloped", "from_m", "a height in metres, such as 1.25"),
    key("sloped", "to_m", "a height in metres, such as 0.8"),
    key("under", "max_area_m2", "an area in square metres, such as 400"),
    key("regions", "name", "a name in quotes"),
    key(
        "regions",
        "at",
        "point(x, y), box(west, south, east, north) or polygon(\"file.geojson\"), in metres",
    ),
    key("regions", "skip", "the reason in quotes"),
    key("regions", "fill", "a section such as (method: field)"),
    key("regions", "water", WATER),
];

/// What says whether there is water, and how high.
const WATER: &str =
    "auto, off, force, level(height in metres), such as level(-0.45), or sloped(from_m: 1.25, to_m: 0.8)";

/// Keys of the design that later versions bring.
const LATER: [&str; 3] = ["facade", "gap", "solver"];

/// What to say about a key that its section does not know; `keys` are all keys of the file.
///
/// `siblings` are the keys of the section. A key that exists elsewhere is sent there; a key of a later version is
/// named as such; else the nearest sibling is proposed, with its unit.
pub(crate) fn advice(keys: &[Key], unknown: &str, siblings: &[&str]) -> String {
    if LATER.contains(&unknown) {
        return format!("`{unknown}` is not in this version; leave it out");
    }
    if let Some(elsewhere) = keys.iter().find(|k| k.name == unknown && !k.section.is_empty()) {
        return format!("`{unknown}` belongs into `{}`: {}", elsewhere.section, elsewhere.meaning);
    }
    match nearest(unknown, siblings) {
        Some(name) => format!("did you mean `{name}`? It takes {}", meaning_among(keys, name, siblings)),
        None => format!("known here: {}", siblings.join(", ")),
    }
}

/// What a key takes. Where two sections share a name, the one whose keys are `siblings` counts.
fn meaning_among(keys: &[Key], name: &str, siblings: &[&str]) -> &'static str {
    let fits = |k: &&Key| {
        k.name == name
            && keys.iter().filter(|other| other.section == k.section).all(|o| siblings.contains(&o.name))
    };
    keys.iter().find(fits).or_else(|| keys.iter().find(|k| k.name == name)).map_or("a value", |k| k.meaning)
}

/// What a key takes, if it is known.
pub(crate) fn meaning(keys: &[Key], name: &str) -> Option<&'static str> {
    keys.iter().find(|k| k.name == name).map(|k| k.meaning)
}

/// The nearest name: fewest edits, where a name that begins with the unknown one (a unit was left out) is one edit
/// away; none if more than half of the letters differ. Ties go to the first name.
pub(crate) fn nearest<'a>(unknown: &str, names: &[&'a str]) -> Option<&'a str> {
    let cost = |name: &str| {
        if name.strip_prefix(unknown).is_some_and(|rest| rest.starts_with('_')) {
            1
        } else {
            edits(unknown, name)
        }
    };
    let best = names.iter().copied().min_by_key(|name| cost(name))?;
    (cost(best) * 2 <= unknown.chars().count().max(2)).then_some(best)
}

/// Fewest insertions, deletions and replacements of characters that turn one word into the other (Levenshtein 1966).
fn edits(from: &str, to: &str) -> usize {
    let to: Vec<char> = to.chars().collect();
    let mut row: Vec<usize> = (0..=to.len()).collect();
    for (i, a) in from.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, b) in to.iter().enumerate() {
            let replaced = diagonal + usize::from(a != *b);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[to.len()]
}

#[cfg(test)]
mod tests {
    use super::{edits, nearest};

    #[test]
    fn counts_edits() {
        for (a, b, count) in [("", "abc", 3), ("kitten", "sitting", 3), ("same", "same", 0), ("ab", "ba", 2)]
        {
            assert_eq!(edits(a, b), count, "{a} {b}");
            assert_eq!(edits(b, a), count, "{b} {a}");
        }
    }

    #[test]
    fn proposes_the_nearest_name_or_none() {
        let names = ["cell_size_m", "cell_origin_m", "up_axis"];
        for (unknown, expected) in [
            ("cell_size", Some("cell_size_m")),
            ("cellsize_m", Some("cell_size_m")),
            ("upaxis", Some("up_axis")),
            ("colour", None),
            ("", None),
        ] {
            assert_eq!(nearest(unknown, &names), expected, "{unknown}");
        }
    }
}
