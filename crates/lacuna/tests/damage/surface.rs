//! Damages to the patches of tiles of the small scene.

use super::PlyTile;

/// Middle of the new faces that use a vertex which was not delivered.
fn inner_face(tile: &PlyTile) -> usize {
    let inner: Vec<usize> = (tile.old_faces..tile.faces.len())
        .filter(|&f| tile.faces[f].iter().all(|&v| v as usize >= tile.old_vertices))
        .collect();
    inner[inner.len() / 2]
}

/// A new vertex on the line x = `x`, away from the line's ends.
fn border_vertex(tile: &PlyTile, x: f32) -> usize {
    let on: Vec<usize> =
        (tile.old_vertices..tile.vertices.len()).filter(|&v| tile.vertices[v][0] == x).collect();
    on[on.len() / 2]
}

/// Lifts a delivered vertex by a centimetre.
pub(crate) fn move_delivered_vertex(tile: &mut PlyTile) {
    tile.vertices[10][2] += 0.01;
}

/// Lifts a new vertex on the border x = 100 by a millimetre.
pub(crate) fn lift_border_vertex(tile: &mut PlyTile) {
    let v = border_vertex(tile, 100.0);
    tile.vertices[v][2] += 1e-3;
}

/// Moves a new vertex on the border x = 100 a millimetre off it.
pub(crate) fn pull_border_vertex(tile: &mut PlyTile) {
    let v = border_vertex(tile, 100.0);
    tile.vertices[v][0] -= 1e-3;
}

/// Lifts the new vertices beyond x = 99.5 by 2 mm, those next to the rim too.
pub(crate) fn raise_overlap(tile: &mut PlyTile) {
    let first = tile.old_vertices;
    tile.vertices[first..].iter_mut().filter(|p| p[0] > 99.5).for_each(|p| p[2] += 2e-3);
}

/// Splits a patch edge that `wanted` accepts at its middle.
fn split_edge(tile: &mut PlyTile, wanted: impl Fn(&PlyTile, u32, u32) -> bool) {
    for f in tile.old_faces..tile.faces.len() {
        let face = tile.faces[f];
        for c in 0..3 {
            let (a, b, apex) = (face[c], face[(c + 1) % 3], face[(c + 2) % 3]);
            if wanted(tile, a, b) {
                let [p, q] = [a, b].map(|v| tile.vertices[v as usize]);
                let middle = tile.vertices.len() as u32;
                tile.vertices.push([0, 1, 2].map(|k| p[k].midpoint(q[k])));
                tile.faces[f] = [a, middle, apex];
                tile.faces.push([middle, b, apex]);
                return;
            }
        }
    }
    panic!("no edge to split");
}

/// Splits a patch edge on the border x = 100 in this tile alone.
pub(crate) fn split_border_edge(tile: &mut PlyTile) {
    split_edge(tile, |t, a, b| {
        [a, b].iter().all(|&v| t.vertices[v as usize][0] == 100.0 && v as usize >= t.old_vertices)
    });
}

/// Splits a patch edge along the rim, where the delivered triangle keeps its whole edge.
pub(crate) fn split_rim_edge(tile: &mut PlyTile) {
    split_edge(tile, |t, a, b| {
        let is_inside = |v: u32| t.vertices[v as usize][..2].iter().all(|x| x.rem_euclid(100.0) > 5.0);
        [a, b].iter().all(|&v| (v as usize) < t.old_vertices && is_inside(v))
    });
}

/// Turns one inner face over.
pub(crate) fn flip_face(tile: &mut PlyTile) {
    let f = inner_face(tile);
    tile.faces[f].swap(0, 1);
}

/// Writes the last face twice.
pub(crate) fn repeat_face(tile: &mut PlyTile) {
    let last = tile.faces[tile.faces.len() - 1];
    tile.faces.push(last);
}

/// Leaves out all new faces.
pub(crate) fn leave_hole_open(tile: &mut PlyTile) {
    tile.faces.truncate(tile.old_faces);
    tile.vertices.truncate(tile.old_vertices);
    tile.header.retain(|line| !line.starts_with("comment lacuna patch"));
}

/// Leaves out one inner face.
pub(crate) fn leave_face_out(tile: &mut PlyTile) {
    let f = inner_face(tile);
    tile.faces.remove(f);
}

/// A second sheet over a third of the patch, half a metre above and a little aside.
pub(crate) fn add_sheet(tile: &mut PlyTile) {
    let new = tile.faces.len() - tile.old_faces;
    let range = tile.old_faces + new / 3..tile.old_faces + 2 * new / 3;
    for f in range {
        let corners = tile.corners(f);
        let first = tile.vertices.len() as u32;
        tile.vertices.extend(corners.map(|[x, y, z]| [x + 0.37, y + 0.21, z + 0.5]));
        tile.faces.push([first, first + 1, first + 2]);
    }
}

/// Gives the patch vertices of its own and lifts them by half a metre: it covers the hole and joins nothing.
pub(crate) fn lift_patch(tile: &mut PlyTile) {
    let first = tile.vertices.len();
    let copies: Vec<[f32; 3]> = tile.vertices.iter().map(|[x, y, z]| [*x, *y, z + 0.5]).collect();
    tile.vertices.extend(copies);
    for face in &mut tile.faces[tile.old_faces..] {
        *face = face.map(|v| v + first as u32);
    }
}

/// Makes the height of an inner vertex no number.
pub(crate) fn lose_height(tile: &mut PlyTile) {
    let v = tile.faces[inner_face(tile)][0] as usize;
    tile.vertices[v][2] = f32::NAN;
}

/// Names a vertex that does not exist.
pub(crate) fn name_missing_vertex(tile: &mut PlyTile) {
    let f = inner_face(tile);
    tile.faces[f][0] = 1_000_000;
}

/// Turns every face over.
pub(crate) fn turn_tile_over(tile: &mut PlyTile) {
    let first = if tile.header.iter().any(|l| l.contains("vertices 0..")) { 0 } else { tile.old_faces };
    tile.faces[first..].iter_mut().for_each(|f| f.swap(0, 1));
}

/// Puts two corners of an inner face at one place.
pub(crate) fn collapse_face(tile: &mut PlyTile) {
    let f = inner_face(tile);
    let [a, b, _] = tile.faces[f];
    tile.faces[f][2] = b;
    tile.faces[f][0] = a;
}

/// Moves an inner vertex over the opposite edge of one of its faces by `past` edge lengths, and `up` metres up.
fn lean(tile: &mut PlyTile, past: f32, up: f32) {
    let f = inner_face(tile);
    let [v, b, c] = tile.faces[f];
    let [p, q] = [b, c].map(|v| tile.vertices[v as usize]);
    let along = [q[0] - p[0], q[1] - p[1]];
    tile.vertices[v as usize] = [
        p[0].midpoint(q[0]) + past * along[1],
        p[1].midpoint(q[1]) - past * along[0],
        p[2].midpoint(q[2]) + up,
    ];
}

/// Folds a patch over itself.
pub(crate) fn fold(tile: &mut PlyTile) {
    lean(tile, 0.15, 0.0);
}

/// Puts up a wall that leans over by a fraction of a millimetre: steep, but no fold.
pub(crate) fn raise_wall(tile: &mut PlyTile) {
    lean(tile, 2e-4, 3.0);
}
