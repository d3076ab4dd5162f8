//! Where a picture needs camera rays.
//!
//! Noise that camera rays make is σ²/n in a pixel that gets n of them. For as many rays in all, noise relative to the light is least where n is
//! in proportion to σ over the light. A few looks before the first pass tell both. What they find holds for all passes, so passes stay
//! independent, and as no ray of the looks is used again the mean is without bias.

use super::maker::PilotBudget;
use super::prepared::{Job, Prepared};
use super::{Pass, Silent};
use crate::color;
use crate::sampling::{Key, Purpose};
use std::sync::Arc;

/// Looks, of one camera ray a pixel each.
const LOOKS: u32 = 4;

/// The looks see photons of one path of so many of a pass.
const PART: u32 = 16;

/// Bounds of what a pixel gets, in shares of the mean.
const FEWEST: f64 = 0.5;
const MOST: f64 = 8.0;

impl Prepared<'_> {
    /// Camera rays of each pixel, by rows from the top, in parts of the mean; `None` where rays make no noise.
    pub fn find_density(&self) -> Option<Arc<[f32]>> {
        let key = Key::new(self.eye.seed).purpose(Purpose::Balance);
        let maps = self.maker.make_from(
            &PilotBudget { key, pass: 0, part: PART, limited: true },
            &Silent,
            &mut Pass::default(),
        );
        // All at one time, as the rays of a pass are.
        let looking = self.at(self.scene).looking();
        let looks: Vec<Vec<f64>> = (0..LOOKS)
            .map(|i| {
                let mut out = Pass::default();
                // Passes that no render reaches.
                looking.walk(&maps, u32::MAX - i, Job::Picture(&Silent, &mut out));
                out.image.iter().map(|v| f64::from(color::mean(*v))).collect()
            })
            .collect();
        let (width, height) = self.scene.camera().size();
        density(&looks, width as usize, height as usize, self.samples)
    }
}

/// See [`Prepared::find_density`]; `looks` are pictures of the same.
fn density(looks: &[Vec<f64>], width: usize, height: usize, samples: u32) -> Option<Arc<[f32]>> {
    let n = looks.len() as f64;
    let mean: Vec<f64> = (0..width * height).map(|i| looks.iter().map(|look| look[i]).sum::<f64>() / n).collect();
    let variance =
        |i: usize| looks.iter().map(|look| (look[i] - mean[i]) * (look[i] - mean[i])).sum::<f64>() / (n - 1.0);
    let variances: Vec<f64> = (0..width * height).map(variance).collect();
    let mut sorted: Vec<f64> = mean.iter().copied().filter(|l| *l > 0.0).collect();
    sorted.sort_by(f64::total_cmp);
    let median = *sorted.get(sorted.len() / 2)?;
    // Few looks know little of one pixel. Its neighbours tell too: the next of its own detail, those around of what is rarely met.
    let around = |values: &[f64], i: usize, reach: usize| {
        let (x, y) = (i % width, i / width);
        let columns = x.saturating_sub(reach)..width.min(x + reach + 1);
        let rows = y.saturating_sub(reach)..height.min(y + reach + 1);
        let count = (columns.len() * rows.len()) as f64;
        rows.flat_map(|y| columns.clone().map(move |x| values[y * width + x])).sum::<f64>() / count
    };
    let wanted: Vec<f64> = (0..width * height)
        .map(|i| {
            let light = around(&mean, i, 1);
            let variance = 0.5 * (around(&variances, i, 1) + around(&variances, i, 4));
            let relative = variance / (light * light + median * median);
            if relative.is_finite() { relative.sqrt() } else { 0.0 }
        })
        .collect();
    let largest = wanted.iter().copied().fold(0.0, f64::max);
    if largest == 0.0 {
        return None;
    }
    // No pixel goes without a ray.
    let fewest = FEWEST.max(1.0 / f64::from(samples));
    let share = |scale: f64, w: f64| (scale * w).clamp(fewest, MOST);
    let total = |scale: f64| wanted.iter().map(|w| share(scale, *w)).sum::<f64>() / wanted.len() as f64;
    let (mut low, mut high) = (0.0, 1.0 / largest);
    // Where few pixels want rays, not all are given out.
    while total(high) < 1.0 && high * largest < MOST * 1e6 {
        high *= 2.0;
    }
    // The mean grows with the scale; sixty halvings leave nothing of the interval.
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if total(middle) > 1.0 { high = middle } else { low = middle }
    }
    Some(wanted.iter().map(|w| share(low, *w) as f32).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The left half is even, the right noisy.
    #[test]
    fn rays_go_where_noise_is_and_are_as_many_in_all() {
        let (width, height) = (16, 8);
        let look = |i: u64| {
            let value = |p: usize| {
                let (x, noise) = (p % width, Key::new(i).with(p as u64).uniform(crate::sampling::Dimension::Film));
                if x < width / 2 { 1.0 } else { 0.5 + f64::from(noise) }
            };
            (0..width * height).map(value).collect::<Vec<f64>>()
        };
        let looks: Vec<Vec<f64>> = (0..64).map(look).collect();
        let found = density(&looks, width, height, 16).unwrap();
        let mean = found.iter().map(|d| f64::from(*d)).sum::<f64>() / found.len() as f64;
        assert!((mean - 1.0).abs() < 1e-3, "{mean}");
        for (i, share) in found.iter().enumerate() {
            match i % width {
                0..4 => assert_eq!(*share, FEWEST as f32),
                // Half of the pixels would get 1.5 of a mean share each, but for those in between, which see both sides.
                12.. => assert!((1.2..1.6).contains(share), "{i}: {share}"),
                _ => {}
            }
        }
        // With one ray a pixel there is none to take away.
        assert!(density(&looks, width, height, 1).unwrap().iter().all(|share| *share == 1.0));
        // A pixel that wants almost nothing takes nothing from the others.
        let mut faint = looks.clone();
        (0..64).for_each(|i| faint[i][0] = 1.0 + 1e-12 * i as f64);
        assert_eq!(density(&faint, width, height, 16).unwrap()[20..], found[20..]);
        assert!(density(&[vec![1.0; 128], vec![1.0; 128]], width, height, 16).is_none());
        assert!(density(&[vec![0.0; 128], vec![0.0; 128]], width, height, 16).is_none());
    }
}
