//! A plant before it is full grown: every root as long as its age lets it be.
//!
//! A main root sets out on day 0, a lateral [`AgeParams::emergence_days`] after its parent's tip has passed its place. From then on a
//! root elongates evenly at its order's rate, each by itself a little faster or slower, until it has the length that it has in the
//! full-grown system. Its base is then as thick as in that, its tip as thin, wherever the tip is. Roots keep their numbers.

use crate::error::{Error, Result};
use crate::roots::Root;
use crate::simulation::noise::{hash, uniform};
use serde::{Deserialize, Serialize};

/// The age of a plant, and how fast its roots grow.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AgeParams {
    /// Days since the main roots set out; full grown when absent.
    pub days: Option<f64>,
    /// Elongation of orders 0, 1 and 2, mm per day.
    pub elongation_mm_per_day: [f64; 3],
    /// Factor to these rates: what a treatment does.
    pub vigour: f64,
    /// Relative spread of the rates: uniform within ± this share, 0 to 0.9.
    pub spread: f64,
    /// Days from when the parent's tip passes a place to when the lateral there sets out.
    pub emergence_days: f64,
}

impl Default for AgeParams {
    fn default() -> Self {
        Self { days: None, elongation_mm_per_day: [9.0, 6.0, 3.0], vigour: 1.0, spread: 0.2, emergence_days: 2.0 }
    }
}

/// Shortest root that there is, mm.
const LEAST_MM: f64 = 0.8;

impl AgeParams {
    /// Fails where a number is out of its range.
    ///
    /// # Errors
    /// Every fault at once, each naming its key.
    pub fn check(&self) -> Result<()> {
        let mut faults = Vec::new();
        let mut need = |ok: bool, key: &str, value: String, remedy: &str| {
            if !ok {
                faults.push(Error::usage(format!("simulate.age.{key} is {value}")).help(remedy));
            }
        };
        let within = |x: f64, low: f64, high: f64| (low..=high).contains(&x);
        let days = self.days.unwrap_or(1.0);
        need(within(days, 0.0, 10_000.0), "days", days.to_string(), "give 0 to 10000 days");
        let rates = self.elongation_mm_per_day;
        need(
            rates.iter().all(|r| within(*r, 0.001, 1000.0)),
            "elongation_mm_per_day",
            format!("{rates:?}"),
            "give three rates of 0.001 to 1000 mm per day",
        );
        need(within(self.vigour, 0.01, 100.0), "vigour", self.vigour.to_string(), "give a factor, 0.01 to 100");
        need(within(self.spread, 0.0, 0.9), "spread", self.spread.to_string(), "give a share, 0 to 0.9");
        let emergence = self.emergence_days;
        need(within(emergence, 0.0, 1000.0), "emergence_days", emergence.to_string(), "give 0 to 1000 days");
        Error::many(faults)
    }
}

/// The full-grown `roots` at their age; a parent stands before its laterals, whose first points are points of it.
pub fn aged(roots: Vec<Root>, params: &AgeParams, seed: u64) -> Vec<Root> {
    let Some(days) = params.days else { return roots };
    // Of each root when it set out, its rate, and how far each of its points is from its base.
    let mut known: Vec<(f64, f64, Vec<f64>)> = Vec::with_capacity(roots.len());
    for root in &roots {
        let draw = |j: u64| 2.0 * uniform(hash(seed, &[211, root.id as u64, j])) - 1.0;
        let order = (root.order as usize).min(2);
        let rate = params.elongation_mm_per_day[order] * params.vigour * (1.0 + params.spread * draw(0));
        let start = match roots.iter().position(|r| r.id == root.parent).filter(|p| *p < known.len()) {
            None => 0.0,
            Some(parent) => {
                let (set_out, pace, arcs) = &known[parent];
                let at = roots[parent].points_mm.iter().position(|p| *p == root.points_mm[0]).unwrap_or(0);
                set_out + arcs[at] / pace + params.emergence_days * (1.0 + params.spread * draw(1))
            }
        };
        known.push((start, rate, arcs(root)));
    }
    let young = |(root, (start, rate, arcs)): (&Root, &(f64, f64, Vec<f64>))| cut(root, arcs, rate * (days - start));
    roots.iter().zip(&known).filter_map(young).collect()
}

fn arcs(root: &Root) -> Vec<f64> {
    let mut arc = 0.0;
    let step = |p: &[[f64; 3]]| (0..3).map(|d| (p[1][d] - p[0][d]).powi(2)).sum::<f64>().sqrt();
    let steps = root.points_mm.windows(2).map(|pair| {
        arc += step(pair);
        arc
    });
    std::iter::once(0.0).chain(steps).collect()
}

/// The root's first `length_mm`; `None` where it is hardly there.
fn cut(root: &Root, arcs: &[f64], length_mm: f64) -> Option<Root> {
    let whole = arcs.last().copied().unwrap_or(0.0);
    let length_mm = length_mm.min(whole);
    if length_mm < LEAST_MM.min(whole) || length_mm <= 0.0 {
        return None;
    }
    let last = arcs.iter().position(|arc| *arc >= length_mm).unwrap_or(arcs.len() - 1);
    let mut points_mm = root.points_mm[..=last].to_vec();
    let share = (length_mm - arcs[last - 1]) / (arcs[last] - arcs[last - 1]);
    let (a, b) = (root.points_mm[last - 1], root.points_mm[last]);
    points_mm[last] = std::array::from_fn(|d| a[d] + share * (b[d] - a[d]));
    let (base, tip) = (root.radii_mm[0], *root.radii_mm.last()?);
    let radii_mm = arcs[..=last].iter().map(|arc| base + (tip - base) * (arc.min(length_mm) / length_mm)).collect();
    Some(Root { points_mm, radii_mm, ..root.clone() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::{Index, Tank};
    use crate::simulation::{GrowthParams, grow};

    fn plant(days: Option<f64>, vigour: f64) -> Vec<Root> {
        let tank = Tank {
            radius_mm: 60.0,
            height_mm: 180.0,
            wall_mm: 4.0,
            water_level_mm: 10.0,
            index: Index::default(),
            belts_mm: vec![],
        };
        let roots = grow(&GrowthParams::default(), &tank, 3).unwrap();
        aged(roots, &AgeParams { days, vigour, ..AgeParams::default() }, 3)
    }

    fn length(root: &Root) -> f64 {
        arcs(root).last().copied().unwrap()
    }

    #[test]
    fn roots_only_grow_at_their_tips_and_keep_their_numbers() {
        let (young, old, whole) = (plant(Some(6.0), 1.0), plant(Some(9.0), 1.0), plant(None, 1.0));
        assert!(young.len() < old.len() && old.len() < whole.len(), "{} {} {}", young.len(), old.len(), whole.len());
        for root in &young {
            let later = old.iter().find(|r| r.id == root.id).unwrap();
            let n = root.points_mm.len() - 1;
            assert!(root.points_mm[..n] == later.points_mm[..n] && root.parent == later.parent);
            assert!(root.radii_mm[0] == later.radii_mm[0] && root.radii_mm.len() == root.points_mm.len());
        }
        assert!(plant(Some(1e4), 1.0).len() == whole.len() && plant(Some(0.0), 1.0).is_empty());
    }

    #[test]
    fn elongation_is_the_rate_and_laterals_wait_for_their_parents_tip() {
        let rate = |order: u32, vigour: f64| {
            let (young, old) = (plant(Some(8.0), vigour), plant(Some(9.0), vigour));
            let full = plant(None, vigour);
            let grown = young.iter().filter(|r| r.order == order).filter_map(|r| {
                let later = old.iter().find(|o| o.id == r.id)?;
                let still = length(later) < length(full.iter().find(|f| f.id == r.id)?) - 1e-6;
                still.then(|| length(later) - length(r))
            });
            let all: Vec<f64> = grown.collect();
            all.iter().sum::<f64>() / all.len() as f64
        };
        assert!(
            (rate(1, 1.0) - 6.0).abs() < 0.6 && (rate(0, 1.0) - 9.0).abs() <= 1.8,
            "{} {}",
            rate(1, 1.0),
            rate(0, 1.0)
        );
        assert!((rate(1, 1.2) / rate(1, 1.0) - 1.2).abs() < 0.05);
        for root in plant(Some(7.0), 1.0).iter().filter(|r| r.order == 1) {
            let parent = plant(Some(7.0), 1.0).into_iter().find(|r| r.id == root.parent).unwrap();
            let at = arcs(&parent)[parent.points_mm.iter().position(|p| *p == root.points_mm[0]).unwrap()];
            assert!(length(&parent) - at > 9.0 * 0.8 * 2.0 * 0.8, "{}", length(&parent) - at);
        }
    }
}
