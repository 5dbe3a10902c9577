//! Numbers that look random and depend on their key alone, so that any cell can be made without the others.

/// Odd constant with evenly spread bits (from the fractional part of the golden ratio).
const SPREAD: u64 = 0x9E37_79B9_7F4A_7C15;
/// Second odd constant, for the multiplier's other half.
const STIR: u64 = 0xD1B5_4A32_D192_ED03;

/// A well-mixed number for a key of integers.
///
/// Each word is folded in by a 64 x 64 -> 128 bit product whose halves are combined.
#[must_use]
pub fn hash(words: &[i64]) -> u64 {
    let mut state = SPREAD;
    for &word in words {
        state = fold(state ^ (word as u64).wrapping_mul(STIR));
    }
    fold(state)
}

fn fold(value: u64) -> u64 {
    let wide = u128::from(value ^ STIR) * u128::from(SPREAD);
    let narrow = (wide as u64) ^ ((wide >> 64) as u64);
    narrow ^ (narrow >> 29)
}

/// The number as a fraction in [0, 1).
#[must_use]
pub fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1u64 << 53) as f64
}

/// A sequence of numbers from one key.
#[derive(Clone, Debug)]
pub struct Rng {
    key: i64,
    count: i64,
}

impl Rng {
    /// The sequence of a key.
    #[must_use]
    pub fn new(words: &[i64]) -> Self {
        Self { key: hash(words) as i64, count: 0 }
    }

    /// The next fraction in [0, 1).
    pub fn unit(&mut self) -> f64 {
        unit(self.bits())
    }

    /// The next number in [low, high).
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// The next integer below `count` (0 if `count` is 0).
    pub fn below(&mut self, count: usize) -> usize {
        ((self.bits() >> 32) as usize * count) >> 32
    }

    /// Puts a list in random order.
    pub fn shuffle<T>(&mut self, list: &mut [T]) {
        for end in (1..list.len()).rev() {
            list.swap(end, self.below(end + 1));
        }
    }

    fn bits(&mut self) -> u64 {
        self.count += 1;
        hash(&[self.key, self.count])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fractions_are_evenly_spread() {
        let mut rng = Rng::new(&[1]);
        let mut bins = [0u32; 10];
        for _ in 0..10_000 {
            bins[(rng.unit() * 10.0) as usize] += 1;
        }
        assert!(bins.iter().all(|&n| (850..1150).contains(&n)), "{bins:?}");
    }

    #[test]
    fn a_shuffle_is_a_permutation_and_moves_things() {
        let mut list: Vec<u32> = (0..100).collect();
        Rng::new(&[2]).shuffle(&mut list);
        assert_ne!(list, (0..100).collect::<Vec<_>>());
        list.sort_unstable();
        assert_eq!(list, (0..100).collect::<Vec<_>>());
    }

    #[test]
    fn keys_that_differ_in_one_bit_or_in_order_give_other_numbers() {
        let keys: [&[i64]; 5] = [&[1, 2], &[2, 1], &[1, 3], &[1], &[1, 2, 0]];
        let mut seen: Vec<u64> = keys.iter().map(|k| hash(k)).collect();
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), keys.len());
    }
}
