//! Layers: the distance of an open hole from the cluster's outside (Wang et al. 2021, sec. 3.2; algorithms note C.2).

/// Layer of every hole of a cluster: 1 where it has original surface on its rim, else one more than its nearest
/// neighbour. `neighbours` holds, for each hole, the holes it shares a border with. 0 = not reached: no hole of the
/// cluster has any surface.
pub(crate) fn layers(has_surface: &[bool], neighbours: &[Vec<usize>]) -> Vec<u32> {
    let mut layer: Vec<u32> = has_surface.iter().map(|&s| u32::from(s)).collect();
    let mut ring: Vec<usize> = (0..layer.len()).filter(|&h| layer[h] == 1).collect();
    while !ring.is_empty() {
        let mut next = Vec::new();
        for &h in &ring {
            for &n in &neighbours[h] {
                if layer[n] == 0 {
                    layer[n] = layer[h] + 1;
                    next.push(n);
                }
            }
        }
        ring = next;
    }
    layer
}

#[cfg(test)]
mod tests {
    use super::layers;

    #[test]
    fn a_lake_of_three_rings() {
        // 5 x 5 cells: the outer ring has surface.
        let at = |i: usize, j: usize| j * 5 + i;
        let mut surface = vec![false; 25];
        let mut neighbours = vec![Vec::new(); 25];
        for j in 0..5 {
            for i in 0..5 {
                surface[at(i, j)] = i == 0 || j == 0 || i == 4 || j == 4;
                if i > 0 {
                    neighbours[at(i, j)].push(at(i - 1, j));
                    neighbours[at(i - 1, j)].push(at(i, j));
                }
                if j > 0 {
                    neighbours[at(i, j)].push(at(i, j - 1));
                    neighbours[at(i, j - 1)].push(at(i, j));
                }
            }
        }
        let found = layers(&surface, &neighbours);
        assert_eq!(found[at(2, 2)], 3);
        assert_eq!(found[at(1, 2)], 2);
        assert_eq!(found[at(0, 2)], 1);
    }

    #[test]
    fn a_cluster_without_surface_has_no_layer() {
        assert_eq!(layers(&[false, false], &[vec![1], vec![0]]), [0, 0]);
    }
}
