//! Other orders of the same triangles.

use crate::random::Rng;
use crate::tile::Tile;

/// Puts the triangles in random order and starts each at a random corner.
pub fn shuffle_triangles(tile: &mut Tile, rng: &mut Rng) {
    rng.shuffle(&mut tile.triangles);
    for triangle in &mut tile.triangles {
        triangle.rotate_left(rng.below(3));
    }
}

/// Puts the vertices in random order; every triangle keeps its corners' places.
pub fn renumber_vertices(tile: &mut Tile, rng: &mut Rng) {
    let mut order: Vec<u32> = (0..tile.vertices.len() as u32).collect();
    rng.shuffle(&mut order);
    let mut new_number = vec![0; order.len()];
    for (new, &old) in order.iter().enumerate() {
        new_number[old as usize] = new as u32;
    }
    tile.vertices = order.iter().map(|&old| tile.vertices[old as usize]).collect();
    for corner in tile.triangles.iter_mut().flatten() {
        *corner = new_number[*corner as usize];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places(tile: &Tile) -> Vec<[[i64; 3]; 3]> {
        let mut all: Vec<[[i64; 3]; 3]> = tile
            .triangles
            .iter()
            .map(|t| {
                let mut corners = t.map(|v| tile.vertices[v as usize]);
                let least = (0..3).min_by_key(|&k| corners[k]).unwrap_or(0);
                corners.rotate_left(least);
                corners
            })
            .collect();
        all.sort_unstable();
        all
    }

    #[test]
    fn orders_change_and_the_surface_does_not() {
        let vertices = (0..20).map(|k| [k, k * k, 0]).collect();
        let triangles = (0..18).map(|k| [k, k + 1, k + 2]).collect();
        let tile = Tile { vertices, triangles };
        let (mut shuffled, mut renumbered) = (tile.clone(), tile.clone());
        shuffle_triangles(&mut shuffled, &mut Rng::new(&[1]));
        renumber_vertices(&mut renumbered, &mut Rng::new(&[1]));
        assert!(shuffled != tile && renumbered != tile);
        assert_eq!(places(&shuffled), places(&tile));
        assert_eq!(places(&renumbered), places(&tile));
    }
}
