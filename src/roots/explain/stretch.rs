//! The stretches of a piece that are worth their cost.

/// Which beads of a piece stay: the stretches whose gains, less `step` each and `end` for either end, sum up to most.
pub fn stretches(gains: &[f32], step: f32, end: f32) -> Vec<bool> {
    // Best sums so far with the bead left out and kept, and whether the bead before was then kept.
    let (mut out, mut kept) = (0.0_f32, f32::NEG_INFINITY);
    let mut came: Vec<[bool; 2]> = Vec::with_capacity(gains.len());
    for gain in gains {
        let [ends, starts] = [kept - end > out, out - end >= kept];
        came.push([ends, !starts]);
        (out, kept) = (if ends { kept - end } else { out }, gain - step + if starts { out - end } else { kept });
    }
    let mut now = kept - end > out;
    let mut stay = vec![false; gains.len()];
    for (stay, came) in stay.iter_mut().zip(&came).rev() {
        *stay = now;
        now = came[usize::from(now)];
    }
    stay
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The sum that a choice is worth.
    fn worth(gains: &[f32], kept: &[bool], step: f32, end: f32) -> f32 {
        let ends = (0..=kept.len()).filter(|&k| (k > 0 && kept[k - 1]) != (k < kept.len() && kept[k])).count();
        gains.iter().zip(kept).filter(|(_, k)| **k).map(|(g, _)| g - step).sum::<f32>() - end * ends as f32
    }

    proptest! {
        #[test]
        fn no_other_choice_is_worth_more(gains in prop::collection::vec(-20..20_i8, 1..11), step in 0..6_u8, end in 0..12_u8) {
            let gains: Vec<f32> = gains.into_iter().map(f32::from).collect();
            let (step, end) = (f32::from(step), f32::from(end));
            let best = (0..1_u32 << gains.len())
                .map(|bits| (0..gains.len()).map(|k| bits >> k & 1 == 1).collect::<Vec<_>>())
                .map(|kept| worth(&gains, &kept, step, end))
                .fold(f32::NEG_INFINITY, f32::max);
            prop_assert_eq!(worth(&gains, &stretches(&gains, step, end), step, end), best);
        }
    }
}
