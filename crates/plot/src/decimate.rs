//! Thinning of long lines to what a pixel column can show.

/// Thins a polyline in page coordinates so that no more than four points fall into one run within a column of
/// width `column`: the first, the lowest, the highest and the last, in their order. The ink is the same,
/// because the line sweeps every height between the extremes anyway. Points that do not leave their column's
/// run are compared only with their neighbors in sequence, so curves that turn back (plan views) are kept.
pub(crate) fn decimate(points: &[(f64, f64)], column: f64) -> Vec<(f64, f64)> {
    let bin = |p: &(f64, f64)| (p.0 / column).floor();
    let mut kept = Vec::new();
    let mut start = 0;
    while start < points.len() {
        let mut end = start + 1;
        let (mut low, mut high) = (start, start);
        while end < points.len() && bin(&points[end]) == bin(&points[start]) {
            if points[end].1 < points[low].1 {
                low = end;
            }
            if points[end].1 > points[high].1 {
                high = end;
            }
            end += 1;
        }
        let mut indices = [start, low.min(high), low.max(high), end - 1].to_vec();
        indices.dedup();
        kept.extend(indices.into_iter().map(|i| points[i]));
        start = end;
    }
    kept
}

/// Leaves out the points of a polyline that lie within `tolerance` of the line through the kept ones (Ramer 1972,
/// Douglas and Peucker 1973), so that smooth lines take few points.
pub(crate) fn simplify(points: &[(f64, f64)], tolerance: f64) -> Vec<(f64, f64)> {
    let Some(last) = points.len().checked_sub(1) else {
        return Vec::new();
    };
    let mut keep = vec![false; points.len()];
    (keep[0], keep[last]) = (true, true);
    let mut open = vec![(0, last)];
    while let Some((start, end)) = open.pop() {
        let distance = |k: usize| distance_to_segment(points[k], points[start], points[end]);
        let farthest = (start + 1..end).map(|k| (k, distance(k))).max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((k, distance)) = farthest
            && distance > tolerance
        {
            keep[k] = true;
            open.extend([(start, k), (k, end)]);
        }
    }
    points.iter().zip(keep).filter_map(|(p, kept)| kept.then_some(*p)).collect()
}

fn distance_to_segment(p: (f64, f64), a: (f64, f64), b: (f64, f64)) -> f64 {
    let (ux, uy) = (b.0 - a.0, b.1 - a.1);
    let (vx, vy) = (p.0 - a.0, p.1 - a.1);
    let length2 = ux * ux + uy * uy;
    let s = if length2 > 0.0 { ((ux * vx + uy * vy) / length2).clamp(0.0, 1.0) } else { 0.0 };
    (vx - s * ux).hypot(vy - s * uy)
}

/// The parts of a polyline inside the horizontal strip `top ≤ y ≤ bottom`, cut exactly at its edges.
pub(crate) fn clip_to_strip(points: &[(f64, f64)], top: f64, bottom: f64) -> Vec<Vec<(f64, f64)>> {
    let mut parts: Vec<Vec<(f64, f64)>> = Vec::new();
    let mut current: Vec<(f64, f64)> = Vec::new();
    if let [only] = points
        && (top..=bottom).contains(&only.1)
    {
        return vec![vec![*only]];
    }
    for pair in points.windows(2) {
        let ((x0, y0), (x1, y1)) = (pair[0], pair[1]);
        // The parameter s ∈ [0, 1] of the segment where it is inside.
        let (mut s0, mut s1) = (0.0_f64, 1.0_f64);
        if y0 == y1 {
            if !(top..=bottom).contains(&y0) {
                s1 = -1.0;
            }
        } else {
            let (a, b) = ((top - y0) / (y1 - y0), (bottom - y0) / (y1 - y0));
            s0 = s0.max(a.min(b));
            s1 = s1.min(a.max(b));
        }
        if s0 > s1 {
            parts.extend((!current.is_empty()).then(|| std::mem::take(&mut current)));
            continue;
        }
        let at = |s: f64| (x0 + s * (x1 - x0), y0 + s * (y1 - y0));
        if current.is_empty() {
            current.push(if s0 == 0.0 { (x0, y0) } else { at(s0) });
        }
        current.push(if s1 == 1.0 { (x1, y1) } else { at(s1) });
        if s1 < 1.0 {
            parts.push(std::mem::take(&mut current));
        }
    }
    parts.extend((!current.is_empty()).then_some(current));
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extremes_and_ends_of_every_column_survive() {
        let points: Vec<(f64, f64)> = (0..200_000)
            .map(|i| {
                let spike = match i {
                    77_777 => 50.0,
                    123_456 => -60.0,
                    _ => 0.0,
                };
                (i as f64 * 700.0 / 2e5, (i as f64 * 0.37).sin() + spike)
            })
            .collect();
        let thin = decimate(&points, 0.5);
        assert!(thin.len() <= 4 * 1401);
        assert!(thin.contains(&points[77_777]));
        assert!(thin.contains(&points[123_456]));
        assert_eq!(thin.first(), points.first());
        assert_eq!(thin.last(), points.last());
        assert!(thin.windows(2).all(|w| w[0].0 <= w[1].0));
    }

    #[test]
    fn short_lines_are_untouched() {
        let points = [(0.0, 1.0), (1.0, 5.0), (2.0, -1.0), (1.2, 0.0)];
        assert_eq!(decimate(&points, 0.5), points);
        assert!(decimate(&[], 0.5).is_empty());
        assert_eq!(decimate(&points[..1], 0.5), &points[..1]);
    }

    #[test]
    fn smooth_lines_take_few_points_and_corners_stay() {
        let sine: Vec<(f64, f64)> =
            (0..3000).map(|k| (f64::from(k) * 0.25, 50.0 * (f64::from(k) * 0.005).sin())).collect();
        let thin = simplify(&sine, 0.05);
        assert!(thin.len() < 200, "{} points", thin.len());
        for p in &sine {
            let near = thin.windows(2).map(|w| distance_to_segment(*p, w[0], w[1])).fold(f64::INFINITY, f64::min);
            assert!(near <= 0.05);
        }
        let square = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0), (0.0, 0.0)];
        assert_eq!(simplify(&square, 0.05), [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0), (0.0, 0.0)]);
        assert!(simplify(&[], 0.05).is_empty());
    }

    #[test]
    fn clipping_cuts_at_the_edge() {
        let zigzag = [(0.0, 0.0), (2.0, 20.0), (4.0, 0.0)];
        let parts = clip_to_strip(&zigzag, 0.0, 10.0);
        assert_eq!(parts, vec![vec![(0.0, 0.0), (1.0, 10.0)], vec![(3.0, 10.0), (4.0, 0.0)]]);
        assert_eq!(clip_to_strip(&zigzag, 0.0, 20.0), vec![zigzag.to_vec()]);
        assert!(clip_to_strip(&[(0.0, 30.0), (1.0, 30.0)], 0.0, 20.0).is_empty());
        assert!(clip_to_strip(&[], 0.0, 20.0).is_empty());
    }
}
