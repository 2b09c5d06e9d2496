//! Numbers that look random and are the same in every run.

/// The generator SplitMix64 (Steele, Lea, and Flood 2014): any seed is as good as another one.
///
/// ```
/// use bracketry_symbolic::SplitMix64;
/// let mut random = SplitMix64::new(7);
/// let first = random.next_u64();
/// assert_eq!(SplitMix64::at(7, 0), first);
/// assert!((0.0..1.0).contains(&random.uniform()));
/// assert!((-3..=5).contains(&random.integer(-3, 5)));
/// ```
#[derive(Clone, Debug)]
pub struct SplitMix64(u64);

/// What the state grows by: 2⁶⁴ over the golden ratio.
const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

impl SplitMix64 {
    /// The sequence of a seed.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The number with this index, from 0, of the sequence of a seed.
    pub fn at(seed: u64, index: u64) -> u64 {
        Self(seed.wrapping_add(index.wrapping_mul(STEP))).next_u64()
    }

    /// The next number.
    pub fn next_u64(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(STEP);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform from 0, below 1.
    pub fn uniform(&mut self) -> f64 {
        (self.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform from −1, below 1.
    pub fn symmetric(&mut self) -> f64 {
        2.0 * self.uniform() - 1.0
    }

    /// From `low` to `high`, both included; `low` where `high` is below it.
    pub fn integer(&mut self, low: i64, high: i64) -> i64 {
        let count = (i128::from(high) - i128::from(low) + 1).max(1);
        let above = i128::from(self.next_u64()) % count;
        (i128::from(low) + above) as i64
    }
}
