//! When two vertices are the same place, and a hash of places.

use glam::DVec3;

/// The position's three bit patterns, with -0 read as +0: two vertices are the same place iff these agree.
#[must_use]
pub fn position_bits(position: DVec3) -> [u64; 3] {
    // -0 + 0 is +0; every other number keeps its bits.
    [position.x + 0.0, position.y + 0.0, position.z + 0.0].map(f64::to_bits)
}

/// True if both positions are the same place.
#[must_use]
pub fn is_same_place(a: DVec3, b: DVec3) -> bool {
    position_bits(a) == position_bits(b)
}

/// The hash of no place: what a non-finite position gets.
pub(crate) const NO_PLACE: u64 = 0;

/// A 64-bit mix of the position bits, `NO_PLACE` iff the position is not finite.
pub(crate) fn place_hash(position: DVec3, seed: u64) -> u64 {
    // Zero times a number is zero iff the number is finite.
    if position.dot(DVec3::ZERO) != 0.0 {
        return NO_PLACE;
    }
    let [x, y, z] = position_bits(position);
    // The odd constants keep the factors from sharing the trailing zeros of round coordinates.
    let xy = fold(x ^ 0x9E6C_63D0_876A_3F6B ^ seed, y ^ 0xD1B5_4A32_D192_ED03);
    finish(fold(xy ^ 0x8CB9_2BA7_2F3D_8DD7, z ^ 0xA24B_AED4_963E_E407).wrapping_add(xy)).max(1)
}

/// A hash of three place hashes in whatever order.
pub(crate) fn triple_hash(mut hashes: [u64; 3]) -> u64 {
    hashes.sort_unstable();
    let [a, b, c] = hashes;
    finish(fold(a ^ 0x9E6C_63D0_876A_3F6B, b ^ 0xD1B5_4A32_D192_ED03) ^ c.rotate_left(29))
}

/// High and low half of the 128-bit product, combined.
fn fold(a: u64, b: u64) -> u64 {
    let product = u128::from(a).wrapping_mul(u128::from(b));
    (product as u64) ^ ((product >> 64) as u64)
}

/// The finisher of splitmix64 (Steele, Lea, Flood 2014): each input bit reaches each output bit.
fn finish(mut h: u64) -> u64 {
    h = (h ^ (h >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    h = (h ^ (h >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    h ^ (h >> 31)
}

/// A table of places: the first vertex of each, numbered in the order of insertion.
pub(crate) struct PlaceTable<'a> {
    positions: &'a [DVec3],
    /// Open addressing: number of the place + 1, 0 = empty.
    slots: Vec<u32>,
    places: Vec<(u64, u32)>,
}

impl<'a> PlaceTable<'a> {
    /// An empty table with room for `capacity` places.
    pub(crate) fn with_capacity(positions: &'a [DVec3], capacity: usize) -> Self {
        let slots = vec![0; (2 * capacity).next_power_of_two().max(2)];
        Self { positions, slots, places: Vec::new() }
    }

    /// The number of the vertex's place; a new one if no vertex was there before.
    pub(crate) fn insert(&mut self, hash: u64, vertex: u32) -> usize {
        let slot = self.slot(hash, vertex);
        if self.slots[slot] == 0 {
            self.places.push((hash, vertex));
            self.slots[slot] = self.places.len() as u32;
        }
        self.slots[slot] as usize - 1
    }

    /// The number of the vertex's place, if it is in the table.
    pub(crate) fn find(&self, hash: u64, vertex: u32) -> Option<usize> {
        (self.slots[self.slot(hash, vertex)] as usize).checked_sub(1)
    }

    /// How many places there are.
    pub(crate) fn len(&self) -> usize {
        self.places.len()
    }

    /// The vertex that was first at this place.
    pub(crate) fn first_vertex(&self, place: usize) -> u32 {
        self.places[place].1
    }

    /// The hash of this place.
    pub(crate) fn hash(&self, place: usize) -> u64 {
        self.places[place].0
    }

    /// Where the vertex's place is, or would go.
    fn slot(&self, hash: u64, vertex: u32) -> usize {
        let mask = self.slots.len() - 1;
        let mut slot = hash as usize & mask;
        while self.slots[slot] != 0 && !self.is_at(self.slots[slot] as usize - 1, hash, vertex) {
            slot = (slot + 1) & mask;
        }
        slot
    }

    fn is_at(&self, place: usize, hash: u64, vertex: u32) -> bool {
        let (own_hash, first) = self.places[place];
        own_hash == hash && is_same_place(self.positions[first as usize], self.positions[vertex as usize])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_has_no_sign() {
        assert!(is_same_place(DVec3::new(-0.0, 1.0, 0.0), DVec3::new(0.0, 1.0, -0.0)));
        assert_eq!(place_hash(DVec3::new(-0.0, 1.0, 0.0), 7), place_hash(DVec3::new(0.0, 1.0, -0.0), 7));
        assert!(!is_same_place(DVec3::ZERO, DVec3::new(f64::MIN_POSITIVE, 0.0, 0.0)));
    }

    #[test]
    fn round_coordinates_do_not_collide() {
        let mut hashes: Vec<u64> = (0..200_000)
            .map(|i| {
                place_hash(DVec3::new(f64::from(i % 200), f64::from(i / 200 % 100), f64::from(i / 20_000)), 0)
            })
            .collect();
        hashes.sort_unstable();
        hashes.dedup();
        assert_eq!(hashes.len(), 200_000);
    }

    #[test]
    fn only_finite_positions_have_a_place() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(place_hash(DVec3::new(0.0, bad, 0.0), 0), NO_PLACE);
        }
        assert_ne!(place_hash(DVec3::ZERO, 0), NO_PLACE);
    }

    #[test]
    fn triples_have_no_order() {
        assert_eq!(triple_hash([3, 1, 2]), triple_hash([2, 1, 3]));
        assert_ne!(triple_hash([3, 1, 2]), triple_hash([3, 1, 4]));
    }

    #[test]
    fn places_are_numbered_in_order_of_insertion() {
        let positions = [DVec3::X, DVec3::Y, DVec3::X, DVec3::Z];
        let hash = |v: u32| place_hash(positions[v as usize], 0);
        let mut table = PlaceTable::with_capacity(&positions, 4);
        let numbers: Vec<usize> = (0..3).map(|v| table.insert(hash(v), v)).collect();
        assert_eq!(numbers, [0, 1, 0]);
        assert_eq!((table.len(), table.first_vertex(0), table.find(hash(3), 3)), (2, 0, None));
    }
}
