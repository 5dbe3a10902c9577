//! GLB: the BIN chunk begins with the delivered one, and the JSON's arrays with their delivered elements, text for text.

use super::{Comparison, Mark};
use serde_json::Value;
use serde_json::value::RawValue;
use std::collections::BTreeMap;

/// Members of the document whose arrays may get further elements.
const GROWING: [&str; 7] = ["buffers", "bufferViews", "accessors", "materials", "meshes", "nodes", "scenes"];

pub(super) fn compare(original: Option<&[u8]>, now: &[u8]) -> Comparison {
    let after = match Container::parse(now) {
        Ok(container) => container,
        Err(problem) => return Comparison { problems: vec![problem], marks: Vec::new() },
    };
    let before = match original.map(Container::parse).transpose() {
        Ok(container) => container,
        Err(problem) => {
            return Comparison { problems: vec![format!("as delivered: {problem}")], marks: Vec::new() };
        }
    };
    let mut problems = Vec::new();
    if let Some(before) = &before {
        compare_containers(before, &after, &mut problems);
    }
    let marks = marks(before.as_ref().map(|b| b.json), after.json);
    Comparison { problems, marks }
}

/// The chunks of a file.
struct Container<'a> {
    json: &'a [u8],
    bin: &'a [u8],
    tail: &'a [u8],
}

impl<'a> Container<'a> {
    fn parse(bytes: &'a [u8]) -> Result<Self, String> {
        if bytes.get(..4) != Some(b"glTF") {
            return Err("not a GLB file".to_owned());
        }
        let length = word(bytes, 8).unwrap_or(0);
        let whole = bytes.get(12..length).ok_or_else(|| format!("the header declares {length} bytes"))?;
        let (json, rest) = chunk(whole, b"JSON").ok_or("no JSON chunk")?;
        let (bin, tail) = chunk(rest, b"BIN\0").unwrap_or((&[], rest));
        Ok(Self { json, bin, tail })
    }
}

fn word(bytes: &[u8], at: usize) -> Option<usize> {
    let four: [u8; 4] = bytes.get(at..at + 4)?.try_into().ok()?;
    usize::try_from(u32::from_le_bytes(four)).ok()
}

/// Content of the first chunk, if it is of this kind, and what follows.
fn chunk<'a>(bytes: &'a [u8], kind: &[u8; 4]) -> Option<(&'a [u8], &'a [u8])> {
    let length = word(bytes, 0)?;
    if bytes.get(4..8)? != kind {
        return None;
    }
    bytes[8..].split_at_checked(length)
}

type Members = BTreeMap<String, Box<RawValue>>;

fn members(text: &str) -> Result<Members, String> {
    serde_json::from_str(text).map_err(|e| format!("the JSON chunk holds {e}"))
}

fn elements(value: Option<&RawValue>) -> Result<Vec<Box<RawValue>>, String> {
    value.map_or(Ok(Vec::new()), |v| {
        serde_json::from_str(v.get()).map_err(|e| format!("the JSON chunk holds {e}"))
    })
}

fn compare_containers(before: &Container<'_>, after: &Container<'_>, problems: &mut Vec<String>) {
    if !after.bin.starts_with(before.bin) {
        let byte = before.bin.iter().zip(after.bin).take_while(|(a, b)| a == b).count();
        problems.push(format!("the BIN chunk is not as delivered from its byte {byte} on"));
    }
    if before.tail != after.tail {
        problems.push("the chunks after BIN are not as delivered".to_owned());
    }
    if let Err(problem) = compare_documents(before.json, after.json, problems) {
        problems.push(problem);
    }
}

fn compare_documents(before: &[u8], after: &[u8], problems: &mut Vec<String>) -> Result<(), String> {
    let text = |json: &'_ [u8]| {
        let end = json.iter().rposition(|b| *b != 0).map_or(0, |last| last + 1);
        String::from_utf8(json[..end].to_vec()).map_err(|_| "the JSON chunk is not UTF-8".to_owned())
    };
    let (before, after) = (members(&text(before)?)?, members(&text(after)?)?);
    for (key, old) in &before {
        let Some(new) = after.get(key) else {
            problems.push(format!("{key} is gone"));
            continue;
        };
        match key.as_str() {
            growing if GROWING.contains(&growing) => compare_arrays(growing, old, new, problems)?,
            _ if old.get() != new.get() => problems.push(format!("{key} is not as delivered")),
            _ => {}
        }
    }
    let added = after.keys().filter(|key| !before.contains_key(*key) && !GROWING.contains(&key.as_str()));
    problems.extend(added.map(|key| format!("{key} was not delivered")));
    Ok(())
}

fn compare_arrays(
    key: &str,
    old: &RawValue,
    new: &RawValue,
    problems: &mut Vec<String>,
) -> Result<(), String> {
    let (old, new) = (elements(Some(old))?, elements(Some(new))?);
    if new.len() < old.len() {
        problems.push(format!("{key} has {} elements, {} were delivered", new.len(), old.len()));
    }
    for (index, (was, is)) in old.iter().zip(&new).enumerate() {
        if was.get() != is.get() && !is_extended(key, index, was, is)? {
            problems.push(format!("{key}[{index}] is not as delivered"));
        }
    }
    Ok(())
}

/// True if an element differs only in what a patch adds: primitives of a mesh, nodes of a scene, the length of buffer 0.
fn is_extended(key: &str, index: usize, was: &RawValue, is: &RawValue) -> Result<bool, String> {
    let grown = match key {
        "meshes" => "primitives",
        "scenes" => "nodes",
        "buffers" if index == 0 => "byteLength",
        _ => return Ok(false),
    };
    let (mut was, mut is) = (members(was.get())?, members(is.get())?);
    let (old, new) = (was.remove(grown), is.remove(grown));
    let same_rest =
        was.len() == is.len() && was.iter().all(|(k, v)| is.get(k).is_some_and(|w| w.get() == v.get()));
    if grown == "byteLength" {
        return Ok(same_rest);
    }
    let (old, new) = (elements(old.as_deref())?, elements(new.as_deref())?);
    let leads = old.len() <= new.len() && old.iter().zip(&new).all(|(a, b)| a.get() == b.get());
    Ok(same_rest && leads)
}

/// Marks of the primitives that the delivered document lacks, in reading order: the scene's nodes depth first, the
/// primitives of a mesh in their order.
fn marks(before: Option<&[u8]>, after: &[u8]) -> Vec<Mark> {
    let parse = |json: &[u8]| {
        let end = json.iter().rposition(|b| *b != 0).map_or(0, |last| last + 1);
        serde_json::from_slice::<Value>(&json[..end]).unwrap_or_default()
    };
    let (before, after) = (before.map(parse).unwrap_or_default(), parse(after));
    let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
    let mut marks = Vec::new();
    for mesh in meshes_in_order(&after) {
        let known = list(&before["meshes"][mesh]["primitives"]).len();
        for primitive in list(&after["meshes"][mesh]["primitives"]).iter().skip(known) {
            if let Some(hole) = primitive["extras"]["lacuna"]["hole"].as_str() {
                let indices = primitive["indices"].as_u64().map_or(usize::MAX, |i| i as usize);
                let corners = after["accessors"][indices]["count"].as_u64().unwrap_or(0);
                marks.push(Mark { hole: hole.to_owned(), triangles: corners / 3 });
            }
        }
    }
    marks
}

fn meshes_in_order(document: &Value) -> Vec<usize> {
    let indices = |value: &Value| -> Vec<usize> {
        let all = value.as_array().map(Vec::as_slice).unwrap_or_default();
        all.iter().filter_map(Value::as_u64).map(|i| i as usize).collect()
    };
    let nodes = document["nodes"].as_array().map(Vec::as_slice).unwrap_or_default();
    let scene = document["scene"].as_u64().unwrap_or(0) as usize;
    let mut waiting = match &document["scenes"][scene]["nodes"] {
        Value::Array(_) => indices(&document["scenes"][scene]["nodes"]),
        _ => {
            let children: Vec<usize> = nodes.iter().flat_map(|n| indices(&n["children"])).collect();
            (0..nodes.len()).filter(|n| !children.contains(n)).collect()
        }
    };
    waiting.reverse();
    let (mut visited, mut meshes) = (vec![false; nodes.len()], Vec::new());
    while let Some(node) = waiting.pop() {
        if visited.get(node).copied().unwrap_or(true) {
            continue;
        }
        visited[node] = true;
        meshes.extend(nodes[node]["mesh"].as_u64().map(|m| m as usize));
        waiting.extend(indices(&nodes[node]["children"]).into_iter().rev());
    }
    meshes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn glb(json: &str, bin: &[u8]) -> Vec<u8> {
        let json = format!("{json}{}", " ".repeat(json.len().next_multiple_of(4) - json.len()));
        let total = 12 + 8 + json.len() + 8 + bin.len();
        let mut file = b"glTF".to_vec();
        for part in
            [&2u32.to_le_bytes()[..], &(total as u32).to_le_bytes(), &(json.len() as u32).to_le_bytes()]
        {
            file.extend_from_slice(part);
        }
        file.extend_from_slice(b"JSON");
        file.extend_from_slice(json.as_bytes());
        file.extend_from_slice(&(bin.len() as u32).to_le_bytes());
        file.extend_from_slice(b"BIN\0");
        file.extend_from_slice(bin);
        file
    }

    const DELIVERED: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"buffers":[{"byteLength":4}],"accessors":[{"count":3}]}"#;

    #[test]
    fn only_ends_of_arrays_may_grow() {
        let delivered = glb(DELIVERED, b"abcd");
        let patched = DELIVERED
            .replace("}}]}]", r#"}},{"indices":1,"extras":{"lacuna":{"hole":"7_8/T"}}}]}]"#)
            .replace("\"byteLength\":4", "\"byteLength\":8")
            .replace(r#"{"count":3}"#, r#"{"count":3},{"count":6}"#);
        let cases = [
            ("grown", glb(&patched, b"abcdefgh"), 0),
            ("other bytes", glb(&patched, b"abXdefgh"), 1),
            ("another number text", glb(&patched.replace("\"count\":3", "\"count\":3.0"), b"abcdefgh"), 1),
            ("a member more", glb(&patched.replacen('{', "{\"extras\":1,", 1), b"abcdefgh"), 1),
            ("another node", glb(&patched.replace("{\"mesh\":0}", "{\"mesh\":1}"), b"abcdefgh"), 1),
            (
                "a primitive changed",
                glb(&patched.replace("\"POSITION\":0", "\"POSITION\":1"), b"abcdefgh"),
                1,
            ),
            ("no GLB", b"glTF".to_vec(), 1),
        ];
        for (name, now, problems) in cases {
            let found = compare(Some(&delivered), &now);
            assert_eq!(found.problems.len(), problems, "{name}: {:?}", found.problems);
        }
        let marks = compare(Some(&delivered), &glb(&patched, b"abcdefgh")).marks;
        assert_eq!(marks, [Mark { hole: "7_8/T".to_owned(), triangles: 2 }]);
    }
}
