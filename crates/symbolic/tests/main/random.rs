//! Random numbers that are the same in every run.

use bracketry_symbolic::SplitMix64;

#[test]
fn the_sequence_is_that_of_the_reference_implementation() {
    // First numbers for the seed 1234567.
    let known = [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423];
    let mut random = SplitMix64::new(1_234_567);
    for (index, number) in known.into_iter().enumerate() {
        assert_eq!((random.next_u64(), SplitMix64::at(1_234_567, index as u64)), (number, number));
    }
}

#[test]
fn uniform_numbers_have_the_moments_of_their_distribution() {
    let mut random = SplitMix64::new(3);
    let numbers: Vec<f64> = (0..40_000).map(|_| random.symmetric()).collect();
    assert!(numbers.iter().all(|x| (-1.0..1.0).contains(x)));
    let mean = |power: i32| numbers.iter().map(|x| x.powi(power)).sum::<f64>() / numbers.len() as f64;
    // Five standard errors: √(1/3), √(4/45) over √40000.
    assert!(mean(1).abs() < 0.0145 && (mean(2) - 1.0 / 3.0).abs() < 0.0075);
}

#[test]
fn integers_cover_their_range_and_no_more() {
    let mut random = SplitMix64::new(5);
    let mut seen = [0; 7];
    (0..7000).for_each(|_| seen[(random.integer(-2, 4) + 2) as usize] += 1);
    assert!(seen.iter().all(|n| (850..1150).contains(n)), "{seen:?}");
    assert_eq!((random.integer(3, 3), random.integer(3, 2)), (3, 3));
    // Nothing overflows.
    random.integer(i64::MIN, i64::MAX);
}
