//! The name that was probably meant.

/// The name nearest to `name` in edit distance, if one is near enough to be meant.
///
/// ```
/// use bracketry_symbolic::closest_name;
/// assert_eq!(closest_name("thetta", ["theta", "x"].into_iter()), Some("theta"));
/// assert_eq!(closest_name("x", ["g", "X"].into_iter()), Some("X"));
/// assert_eq!(closest_name("x", ["g", "xi"].into_iter()), None);
/// ```
pub fn closest_name<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    // One letter of a short name is most of it: only case may differ.
    let limit = name.chars().count() / 3;
    known
        .map(|k| (distance(name, k), k))
        .filter(|(d, k)| *d <= limit && *d < k.chars().count().max(2))
        .min_by_key(|(d, _)| *d)
        .map(|(_, k)| k)
}

/// Levenshtein distance, where a change of case counts nothing.
fn distance(a: &str, b: &str) -> usize {
    let a: Vec<char> = a.to_lowercase().chars().collect();
    let b: Vec<char> = b.to_lowercase().chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut diagonal = row[0];
        row[0] = i;
        for j in 1..=b.len() {
            let change = diagonal + usize::from(a[i - 1] != b[j - 1]);
            diagonal = row[j];
            row[j] = change.min(row[j] + 1).min(row[j - 1] + 1);
        }
    }
    row[b.len()]
}
