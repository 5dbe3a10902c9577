//! OBJ: the delivered file is a prefix of the written one.

use super::{Comparison, Mark};

/// The line that begins our statements.
const FIRST_LINE: &[u8] = b"# lacuna patch";
/// Begins the line before the faces of a hole.
const HOLE_LINE: &[u8] = b"# hole ";

pub(super) fn compare(original: Option<&[u8]>, now: &[u8]) -> Comparison {
    let original = original.unwrap_or_default();
    let Some(added) = now.strip_prefix(original) else {
        let common = original.iter().zip(now).take_while(|(a, b)| a == b).count();
        let line = original[..common].iter().filter(|b| **b == b'\n').count() + 1;
        return Comparison { problems: vec![format!("line {line} is not as delivered")], marks: Vec::new() };
    };
    let mut comparison = Comparison { marks: marks(added), ..Comparison::default() };
    // A missing line end, or one behind a backslash, is closed with one or two line feeds first.
    let statements = added.iter().position(|b| *b != b'\n').map_or(&[][..], |first| &added[first..]);
    let is_closed = original.is_empty() || original.ends_with(b"\n") || added.starts_with(b"\n");
    if !statements.starts_with(FIRST_LINE) || !is_closed {
        comparison.problems.push("what follows the delivered bytes is no patch".to_owned());
    }
    comparison
}

/// Faces below each hole's line.
fn marks(added: &[u8]) -> Vec<Mark> {
    let mut marks: Vec<Mark> = Vec::new();
    for line in added.split(|b| *b == b'\n') {
        let line = line.trim_ascii_end();
        if let Some(hole) = line.strip_prefix(HOLE_LINE) {
            marks.push(Mark { hole: String::from_utf8_lossy(hole).into_owned(), triangles: 0 });
        } else if line.starts_with(b"f ")
            && let Some(mark) = marks.last_mut()
        {
            mark.triangles += 1;
        }
    }
    marks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_appended_may_differ() {
        let patch =
            "# lacuna patch\nmtllib t_lacuna.mtl\n# hole 1_2/t\nf 1 2 3\nf 2 3 4\n# hole 3\nf 3 4 5\n";
        let cases = [
            ("v 0 0 0\n", format!("v 0 0 0\n{patch}"), 0),
            ("v 0 0 0", format!("v 0 0 0\n{patch}"), 0),
            ("v 0 0 0 \\", format!("v 0 0 0 \\\n\n{patch}"), 0),
            ("v 0 0 0", format!("v 0 0 0{patch}"), 1),
            ("v 0 0 0\n", format!("v 0 0 1\n{patch}"), 1),
            ("v 0 0 0\n", format!("v 0 0 0\nv 1 1 1\n{patch}"), 1),
            ("v 0 0 0\n", "v 0 0".to_owned(), 1),
        ];
        for (original, now, problems) in cases {
            let found = compare(Some(original.as_bytes()), now.as_bytes());
            assert_eq!(found.problems.len(), problems, "{original:?} -> {now:?}: {:?}", found.problems);
        }
        let marks = compare(Some(b""), patch.as_bytes()).marks;
        let expected = [("1_2/t", 2), ("3", 1)].map(|(h, t)| Mark { hole: h.to_owned(), triangles: t });
        assert_eq!(marks, expected);
    }
}
