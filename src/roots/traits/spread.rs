//! The spread of traits over repeated reconstructions, as from resampled views.

use super::Trait;
use serde::Serialize;

/// How a trait varies; a row of `trait_spread.csv`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Spread {
    /// The trait with its unit.
    pub name: String,
    /// Tables that hold a finite value.
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

/// The spread of every trait of the first table over all tables.
pub fn spread(tables: &[Vec<Trait>]) -> Vec<Spread> {
    let Some(first) = tables.first() else { return Vec::new() };
    let of = |name: &str| {
        let mut values: Vec<f64> = tables
            .iter()
            .filter_map(|t| t.iter().find(|x| x.name == name).map(|x| x.value))
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
            name: name.to_string(),
            count: values.len(),
            mean,
            sd: (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt(),
            low_2_5: quantile(0.025),
            high_97_5: quantile(0.975),
        }
    };
    first.iter().map(|t| of(&t.name)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_sd_and_quantiles() {
        let table = |v: f64| vec![Trait { name: "a_mm".into(), value: v }];
        let s = spread(&[table(1.0), table(2.0), table(3.0), table(f64::NAN)]);
        assert_eq!((s[0].count, s[0].mean, s[0].sd), (3, 2.0, 1.0));
        assert!((s[0].low_2_5 - 1.05).abs() < 1e-12 && (s[0].high_97_5 - 2.95).abs() < 1e-12);
        assert!(spread(&[]).is_empty());
    }
}
