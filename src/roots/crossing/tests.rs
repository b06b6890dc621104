use super::*;
use crate::roots::ridge::{Field, RidgePoint};
use crate::volume::Grid;
use ndarray::Array3;

/// Ridge points along polylines, each one strand.
fn strands(ways: &[Vec<Vec3>]) -> (Vec<RidgePoint>, Vec<Vec<usize>>) {
    let (mut points, mut chains) = (Vec::new(), Vec::new());
    for way in ways {
        let mut chain = Vec::new();
        for leg in way.windows(2) {
            let (step, n) = (leg[1] - leg[0], ((leg[1] - leg[0]).norm() / 0.5).round() as usize);
            for k in 0..n {
                chain.push(points.len());
                points.push(RidgePoint {
                    position_mm: leg[0] + step * (k as f64 / n as f64),
                    tangent: step.normalize(),
                    rootness: 1.0,
                    sigma_mm: 0.3,
                    strong: true,
                });
            }
        }
        chains.push(chain);
    }
    (points, chains)
}

/// Both ends of every strand after the crossings were looked at, and the number of repairs.
fn resolved(ways: &[Vec<Vec3>]) -> (Vec<[Vec3; 2]>, usize) {
    let (points, chains) = strands(ways);
    let grid = Grid { origin_mm: [-20.0; 3], spacing_mm: 1.0, shape: [41, 41, 41] };
    let rootness = Array3::zeros((41, 41, 41));
    let field = Field { grid, rootness: rootness.view() };
    let workshop = Workshop { points: &points, field, step_mm: 0.5, wavelength_mm: 6.0, link_mm: 1.3 };
    let made = chains.into_iter().map(|chain| workshop.strand(chain)).collect();
    let mut log = Vec::new();
    let found = resolve(made, &workshop, &CrossingParams::default(), &mut log);
    (found.iter().map(|s| [s.at(0), s.at(s.knots.len() - 1)]).collect(), log.len())
}

fn joins(found: &[[Vec3; 2]], a: Vec3, b: Vec3) -> bool {
    let near = |p: &Vec3, q: &Vec3| (p - q).norm() < 1.5;
    found.iter().any(|[p, q]| near(p, &a) && near(q, &b) || near(p, &b) && near(q, &a))
}

const WEST: Vec3 = Vec3::new(-15.0, -3.0, 0.0);
const EAST: Vec3 = Vec3::new(15.0, 3.0, 0.0);
const SOUTH: Vec3 = Vec3::new(3.0, -15.0, 0.4);
const NORTH: Vec3 = Vec3::new(-3.0, 15.0, 0.4);

#[test]
fn roots_that_swapped_partners_get_them_back() {
    let middle = Vec3::new(0.0, 0.0, 0.2);
    let (found, repairs) = resolved(&[vec![WEST, middle, NORTH], vec![SOUTH, middle + Vec3::z() * 0.3, EAST]]);
    assert_eq!((found.len(), repairs), (2, 1));
    assert!(joins(&found, WEST, EAST) && joins(&found, SOUTH, NORTH));
}

#[test]
fn a_root_cut_by_another_goes_on_behind_it() {
    // The ends bend towards the root that they meet.
    let bent = [Vec3::new(-1.6, 0.0, 0.2), Vec3::new(1.6, 0.0, 0.2)];
    let (found, repairs) = resolved(&[
        vec![SOUTH, NORTH],
        vec![WEST, bent[0] * 1.5, bent[0] * 0.5],
        vec![bent[1] * 0.5, bent[1] * 1.5, EAST],
    ]);
    assert_eq!((found.len(), repairs), (2, 1));
    assert!(joins(&found, WEST, EAST) && joins(&found, SOUTH, NORTH));
}

#[test]
fn laterals_and_roots_that_cross_straight_stay_as_they_are() {
    let straight = [vec![WEST, EAST], vec![SOUTH, NORTH]];
    assert_eq!(resolved(&straight).1, 0);
    let lateral = [vec![SOUTH, NORTH], vec![Vec3::new(0.6, 0.0, 0.4), Vec3::new(12.0, 6.0, 0.4)]];
    let (found, repairs) = resolved(&lateral);
    assert_eq!((found.len(), repairs), (2, 0));
    assert!(joins(&found, SOUTH, NORTH));
}

#[test]
fn nothing_closes_a_ring() {
    // Two halves of a circle: their ends meet and continue each other at both places, and one may be joined.
    let half = |from: f64| -> Vec<Vec3> {
        let angle = |k: u32| (from + 0.6 + f64::from(k) * 178.8 / 24.0).to_radians();
        (0..=24).map(|k| Vec3::new(40.0 * angle(k).cos(), 40.0 * angle(k).sin(), 0.0)).collect()
    };
    let (found, repairs) = resolved(&[half(0.0), half(180.0)]);
    assert_eq!((found.len(), repairs), (1, 1));
}
