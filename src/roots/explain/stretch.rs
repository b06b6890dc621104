//! The stretches of a piece that are worth their cost.

/// What stretches cost, in logarithms of likelihood.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Costs {
    /// A bead.
    pub step: f32,
    /// Either end of the piece, where a stretch reaches it.
    pub end: f32,
    /// Either end of a stretch within the piece.
    pub cut: f32,
}

/// Which beads of a piece stay: the stretches whose gains, less their costs, sum up to most.
pub fn stretches(gains: &[f32], costs: &Costs) -> Vec<bool> {
    let Costs { step, end, cut } = *costs;
    // Best sums so far with the bead left out and kept, and whether the bead before was then kept.
    let (mut out, mut kept) = (0.0_f32, f32::NEG_INFINITY);
    let mut came: Vec<[bool; 2]> = Vec::with_capacity(gains.len());
    for (k, gain) in gains.iter().enumerate() {
        let start = out - if k == 0 { end } else { cut };
        let [ends, starts] = [kept - cut > out, start >= kept];
        came.push([ends, !starts]);
        (out, kept) = (if ends { kept - cut } else { out }, gain - step + if starts { start } else { kept });
    }
    let mut now = kept - end > out;
    let mut stay = vec![false; gains.len()];
    for (stay, came) in stay.iter_mut().zip(&came).rev() {
        *stay = now;
        now = came[usize::from(now)];
    }
    stay
}

/// How probably each bead stays where choices are as probable as e to their worth over `heat`: marginals of a two-state chain,
/// by the forward-backward recursion.
pub fn probable(gains: &[f32], costs: &Costs, heat: f32) -> Vec<f32> {
    let n = gains.len();
    let add = |a: f32, b: f32| a.max(b) + (-(a - b).abs()).exp().ln_1p();
    let (end, cut) = (-costs.end / heat, -costs.cut / heat);
    let kept = |k: usize| (gains[k] - costs.step) / heat;
    // Logarithms of the sums over all choices up to a bead, and from it on, with the bead left out and kept.
    let mut before = vec![[0.0_f32; 2]; n];
    for k in 0..n {
        let [out, stays] = if k == 0 { [0.0, end] } else { before[k - 1] };
        before[k] =
            if k == 0 { [0.0, end + kept(0)] } else { [add(out, stays + cut), add(out + cut, stays) + kept(k)] };
    }
    let mut behind = [0.0, end];
    let mut stay = vec![0.0; n];
    for k in (0..n).rev() {
        let ratio = before[k][1] + behind[1] - before[k][0] - behind[0];
        stay[k] = 1.0 / (1.0 + (-ratio).exp());
        let goes = behind[1] + kept(k);
        behind = [add(behind[0], goes + cut), add(behind[0] + cut, goes)];
    }
    stay
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The sum that a choice is worth.
    fn worth(gains: &[f32], kept: &[bool], costs: &Costs) -> f32 {
        let cuts = kept.windows(2).filter(|w| w[0] != w[1]).count() as f32;
        let ends = [kept[0], kept[kept.len() - 1]].into_iter().filter(|k| *k).count() as f32;
        let own: f32 = gains.iter().zip(kept).filter(|(_, k)| **k).map(|(g, _)| g - costs.step).sum();
        own - costs.end * ends - costs.cut * cuts
    }

    fn choices(n: usize) -> impl Iterator<Item = Vec<bool>> {
        (0..1_u32 << n).map(move |bits| (0..n).map(|k| bits >> k & 1 == 1).collect())
    }

    prop_compose! {
        fn piece()(gains in prop::collection::vec(-20..20_i8, 1..11), costs in [0..6_u8, 0..12_u8, 0..12_u8])
            -> (Vec<f32>, Costs) {
            let [step, end, cut] = costs.map(f32::from);
            (gains.into_iter().map(f32::from).collect(), Costs { step, end, cut })
        }
    }

    proptest! {
        #[test]
        fn no_other_choice_is_worth_more((gains, costs) in piece()) {
            let best = choices(gains.len()).map(|kept| worth(&gains, &kept, &costs)).fold(f32::NEG_INFINITY, f32::max);
            prop_assert_eq!(worth(&gains, &stretches(&gains, &costs), &costs), best);
        }

        #[test]
        fn marginals_are_those_of_all_choices((gains, costs) in piece(), heat in 1.0..30.0_f32) {
            let stay = probable(&gains, &costs, heat);
            let weigh = |kept: &[bool]| f64::from(worth(&gains, kept, &costs) / heat).exp();
            let all: f64 = choices(gains.len()).map(|kept| weigh(&kept)).sum();
            for (k, stay) in stay.iter().enumerate() {
                let with: f64 = choices(gains.len()).filter(|kept| kept[k]).map(|kept| weigh(&kept)).sum();
                prop_assert!((f64::from(*stay) - with / all).abs() < 1e-3, "{} for {}", stay, with / all);
            }
        }
    }
}
