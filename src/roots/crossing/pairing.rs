//! The cheapest pairing of some ways.

/// Per way the one that it goes on in.
pub type Pairing = Vec<Option<usize>>;

/// Of all pairings the cheapest: pairs cost `costs[a][b]` (symmetric; infinite where they cannot be), whoever stays alone
/// `alone`, and the pairing that `stood` `alone` less. Of equal ones the first found counts, that which stood before all.
pub fn cheapest(costs: &[Vec<f64>], alone: f64, stood: &Pairing) -> Pairing {
    let standing = total(costs, alone, stood) - alone;
    let mut search = Search { costs, alone, trial: vec![None; stood.len()], best: (standing, stood.clone()) };
    search.from(0, &mut vec![false; stood.len()], 0.0);
    search.best.1
}

fn total(costs: &[Vec<f64>], alone: f64, pairing: &Pairing) -> f64 {
    pairing.iter().enumerate().map(|(a, b)| b.map_or(alone, |b| 0.5 * costs[a][b])).sum()
}

struct Search<'a> {
    costs: &'a [Vec<f64>],
    alone: f64,
    trial: Pairing,
    best: (f64, Pairing),
}

impl Search<'_> {
    /// Tries every pairing of the ways from `a` on that are not done.
    fn from(&mut self, a: usize, done: &mut [bool], so_far: f64) {
        if so_far >= self.best.0 {
            return;
        }
        let Some(a) = (a..done.len()).find(|&a| !done[a]) else {
            self.best = (so_far, self.trial.clone());
            return;
        };
        done[a] = true;
        for b in a + 1..done.len() {
            if done[b] || self.costs[a][b].is_infinite() {
                continue;
            }
            done[b] = true;
            (self.trial[a], self.trial[b]) = (Some(b), Some(a));
            self.from(a + 1, done, so_far + self.costs[a][b]);
            (self.trial[a], self.trial[b]) = (None, None);
            done[b] = false;
        }
        self.from(a + 1, done, so_far + self.alone);
        done[a] = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    /// Every pairing of n ways.
    fn all(n: usize) -> Vec<Pairing> {
        let mut list = vec![vec![None; n]];
        for a in 0..n {
            for b in a + 1..n {
                let more: Vec<Pairing> = list.iter().filter(|p| p[a].is_none() && p[b].is_none()).cloned().collect();
                list.extend(more.into_iter().map(|mut p| {
                    (p[a], p[b]) = (Some(b), Some(a));
                    p
                }));
            }
        }
        list
    }

    #[test]
    fn no_pairing_is_cheaper() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        for _ in 0..200 {
            let n = rng.random_range(2..7);
            let mut costs = vec![vec![f64::INFINITY; n]; n];
            for (a, b) in (0..n).flat_map(|a| (a + 1..n).map(move |b| (a, b))) {
                if rng.random_range(0..3) > 0 {
                    costs[a][b] = rng.random_range(0.0..4.0);
                    costs[b][a] = costs[a][b];
                }
            }
            let stood: Pairing = vec![None; n];
            let found = total(&costs, 1.0, &cheapest(&costs, 1.0, &stood));
            let least = all(n).iter().map(|p| total(&costs, 1.0, p)).fold(f64::INFINITY, f64::min);
            // What stood gives way to what is cheaper by more than one alone.
            let stands = total(&costs, 1.0, &stood);
            assert_eq!(found, if least < stands - 1.0 { least } else { stands });
        }
    }
}
