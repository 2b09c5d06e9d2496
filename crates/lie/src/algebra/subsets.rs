//! Subsets in lexicographic order.

/// All subsets of 0 … n − 1 with `size` elements.
pub(crate) fn subsets(n: usize, size: usize) -> impl Iterator<Item = Vec<usize>> {
    let mut next: Option<Vec<usize>> = (size <= n).then(|| (0..size).collect());
    std::iter::from_fn(move || {
        let now = next.clone()?;
        next = (0..size).rev().find(|&i| now[i] < n - size + i).map(|i| {
            let mut s = now.clone();
            s[i] += 1;
            for j in i + 1..size {
                s[j] = s[j - 1] + 1;
            }
            s
        });
        Some(now)
    })
}
