//! The spread of traits over reconstructions from resampled views.
//!
//! Each draw reconstructs from a random half of the views, without replacement: for a mean over n views the spread of
//! such halves is that of the mean of all n, so `sd` estimates the standard deviation of the trait as measured. Half
//! the views also see less: what that costs is `mean` less `value`.

use super::Trait;
use rand::SeedableRng;
use rand::seq::index::sample;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

/// The views of each of `draws` random halves of `views`, ascending; always the same halves.
pub fn halves(views: usize, draws: usize) -> Vec<Vec<usize>> {
    (0..draws)
        .map(|draw| {
            let mut rng = ChaCha8Rng::seed_from_u64(draw as u64);
            let mut half = sample(&mut rng, views, views / 2).into_vec();
            half.sort_unstable();
            half
        })
        .collect()
}

/// How a trait varies; a row of `trait_spread.csv`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Spread {
    /// The trait with its unit.
    pub name: String,
    /// From all views.
    pub value: f64,
    /// Draws that gave a finite value.
    pub count: usize,
    /// Mean of the values.
    pub mean: f64,
    /// Their standard deviation (n - 1); NaN for fewer than two.
    pub sd: f64,
    /// 2.5 % quantile (linear between order statistics).
    pub low_2_5: f64,
    /// 97.5 % quantile.
    pub high_97_5: f64,
}

/// The spread over the draws of every trait in the table from all views.
pub fn spread(all: &[Trait], draws: &[Vec<Trait>]) -> Vec<Spread> {
    let of = |whole: &Trait| {
        let mut values: Vec<f64> = draws
            .iter()
            .filter_map(|t| t.iter().find(|x| x.name == whole.name).map(|x| x.value))
            .filter(|v| v.is_finite())
            .collect();
        values.sort_by(f64::total_cmp);
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let quantile = |share: f64| {
            let at = share * (n - 1.0);
            match values.get(at as usize) {
                None => f64::NAN,
                Some(low) => {
                    let high = values.get(at as usize + 1).unwrap_or(low);
                    low + at.fract() * (high - low)
                }
            }
        };
        Spread {
            name: whole.name.clone(),
            value: whole.value,
            count: values.len(),
            mean,
            sd: (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt(),
            low_2_5: quantile(0.025),
            high_97_5: quantile(0.975),
        }
    };
    all.iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_sd_and_quantiles() {
        let table = |v: f64| vec![Trait { name: "a_mm".into(), value: v }];
        let s = spread(&table(2.5), &[table(1.0), table(2.0), table(3.0), table(f64::NAN)]);
        assert_eq!((s[0].value, s[0].count, s[0].mean, s[0].sd), (2.5, 3, 2.0, 1.0));
        assert!((s[0].low_2_5 - 1.05).abs() < 1e-12 && (s[0].high_97_5 - 2.95).abs() < 1e-12);
        assert!(spread(&[], &[]).is_empty());
        let drawn = halves(9, 20);
        assert!(drawn.iter().all(|h| h.len() == 4 && h.windows(2).all(|w| w[0] < w[1]) && h[3] < 9));
        assert!(drawn.iter().collect::<std::collections::BTreeSet<_>>().len() > 15);
    }
}
