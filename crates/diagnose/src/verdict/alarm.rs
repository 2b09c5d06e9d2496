//! Whether the residual of a fit is more than noise.

use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use bracketry_numerics::statistics::median;

use crate::WindowFit;
use crate::settings::AlarmSettings;

/// The residual of a fit, against noise.
///
/// Each window's residual is expanded in cosines (orthonormal, DCT-II). White noise gives all of them the same variance;
/// what a model gets wrong acts through forces that are integrated twice, so that it gathers at low frequencies. The upper
/// half of the spectrum is the measure of the noise, by column, which makes a wrong estimate of its size harmless. The sum
/// of squares over the lowest K cosines of all windows is compared with it by Fisher's F, for K = 2, 4, 8 … up to a quarter
/// of the spectrum, and the smallest p-value multiplied by the number of tests (an adaptive Neyman smooth test; Fan 1996).
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Alarm {
    /// Variance of the noise by measured column, in units of the estimate from the column itself.
    pub(crate) noise: Vec<f64>,
    /// Probability of such a residual if there were only white noise.
    pub(crate) p_value: f64,
    /// Root mean square of the residual over its noise, 1 for noise alone.
    pub(crate) size: f64,
    /// Sum of squares that noise alone would leave, in the units of the fit (of the estimated noise's variance).
    pub(crate) floor: f64,
    /// Sum of squares of the residual.
    pub(crate) square: f64,
    /// Degrees of freedom: samples minus what was fitted.
    pub(crate) freedom: f64,
}

impl Alarm {
    /// Of fitted windows; `fitted` coefficients were adapted in common, `initial` per window.
    pub(crate) fn of(windows: &[WindowFit], initial: usize, fitted: usize, settings: &AlarmSettings) -> Self {
        let spectra: Vec<(usize, Spectrum)> = windows
            .iter()
            .flat_map(|w| w.residuals.iter().enumerate())
            .filter_map(|(column, values)| Some((column, Spectrum::of(values, settings.fewest_samples)?)))
            .collect();
        let columns = spectra.iter().map(|s| s.0 + 1).max().unwrap_or(0);
        let mut noise = vec![1.0; columns];
        let mut reference = 0.0;
        for (column, noise) in noise.iter_mut().enumerate() {
            let own = spectra.iter().filter(|s| s.0 == column).map(|s| &s.1);
            let (sum, count) = own.fold((0.0, 0), |(sum, count), s| (sum + s.high, count + s.high_count));
            if count > 0 {
                *noise = (sum / count as f64).max(settings.least_noise * settings.least_noise);
            }
            reference += count as f64;
        }
        let running = windows.iter().filter(|w| w.count > 0).count();
        let eliminated = (running * initial + fitted) as f64;
        let mut p_value = 1.0_f64;
        let mut tests = 0.0;
        let scales = spectra.iter().map(|s| s.1.low.len()).max().unwrap_or(0);
        for scale in 0..scales {
            let mut energy = 0.0;
            let mut count = 0.0;
            for (column, s) in &spectra {
                if let Some((sum, n)) = s.low.get(scale).or(s.low.last()) {
                    energy += sum / noise[*column];
                    count += *n as f64;
                }
            }
            let freedom = count - eliminated;
            if freedom < 1.0 || freedom < 0.25 * count || reference < 1.0 {
                continue;
            }
            tests += 1.0;
            p_value = p_value.min(upper_tail(energy / freedom, freedom, reference));
        }
        let square: f64 = windows.iter().map(|w| w.square).sum();
        let samples: f64 = windows.iter().map(|w| w.count as f64).sum();
        let freedom = (samples - eliminated).max(1.0);
        let (weighted, counted) =
            spectra.iter().fold((0.0, 0.0), |(a, b), (c, s)| (a + noise[*c] * s.count as f64, b + s.count as f64));
        let level = if counted > 0.0 { weighted / counted } else { 1.0 };
        let floor = level * freedom;
        Self { noise, p_value: (p_value * tests).min(1.0), size: (square / floor).sqrt(), floor, square, freedom }
    }

    /// Sum of squares beyond that of noise.
    pub(crate) fn excess(&self) -> f64 {
        (self.square - self.floor).max(0.0)
    }
}

/// Probability that Fisher's F with these degrees of freedom exceeds `f`.
pub(crate) fn upper_tail(f: f64, numerator: f64, denominator: f64) -> f64 {
    if !(f > 0.0 && f.is_finite()) {
        return if f > 0.0 { 0.0 } else { 1.0 };
    }
    FisherSnedecor::new(numerator, denominator).map_or(1.0, |d| d.sf(f))
}

/// Energy of one column of one window by frequency.
struct Spectrum {
    /// Sum of squares and number of the lowest 2, 4, 8 … cosines.
    low: Vec<(f64, usize)>,
    /// Sum of squares of the upper half.
    high: f64,
    high_count: usize,
    /// Samples.
    count: usize,
}

impl Spectrum {
    /// `None` if fewer than `fewest` samples are there to tell low from high, or a fifth of them are lost. A sensor that is slower than the
    /// record has its own samples.
    fn of(values: &[f64], fewest: usize) -> Option<Self> {
        let known: Vec<usize> = (0..values.len()).filter(|&k| values[k].is_finite()).collect();
        let samples: Vec<f64> = known.iter().map(|&k| values[k]).collect();
        let n = samples.len();
        let apart = median(known.windows(2).map(|w| (w[1] - w[0]) as f64).collect()).unwrap_or(1.0);
        if n < fewest || 5.0 * n as f64 * apart < 4.0 * (values.len() as f64 - apart) {
            return None;
        }
        let total: f64 = samples.iter().map(|v| v * v).sum();
        let half = n / 2;
        let mut low = Vec::new();
        let mut energy = 0.0;
        let mut next = 2;
        for k in 0..half {
            let rate = std::f64::consts::PI * k as f64 / n as f64;
            let sum = cosine_sum(&samples, rate);
            let norm = if k == 0 { 1.0 } else { 2.0 } / n as f64;
            energy += norm * sum * sum;
            if k + 1 == next && 4 * next <= n {
                low.push((energy, next));
                next *= 2;
            }
        }
        Some(Self { low, high: (total - energy).max(0.0), high_count: n - half, count: n })
    }
}

/// `Σ x_i cos(rate (i + 1/2))`, by the recurrence of Chebyshev (Clenshaw's summation).
fn cosine_sum(x: &[f64], rate: f64) -> f64 {
    let double = 2.0 * rate.cos();
    let (mut b1, mut b2) = (0.0, 0.0);
    for &value in x.iter().rev() {
        let b0 = value + double * b1 - b2;
        b2 = b1;
        b1 = b0;
    }
    // Σ x_i cos((i + 1/2) w) = (b_0 − b_1) cos(w/2).
    (b1 - b2) * (0.5 * rate).cos()
}
