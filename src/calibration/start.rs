//! A first tank frame, found without help: the ring of cameras gives the axis and its sense, the belts'
//! points lie on a cylinder of known radius.
//!
//! The table turns about one axis, so that this axis looks the same from every camera: its direction `a`
//! minimises the variance of `R_l a`, i.e. it is the right singular vector of `Σ R_l` with the largest
//! singular value. It points down where most cameras see it point down. Points projected along it lie on
//! a circle (RANSAC over triples, then a robust fit of the whole cylinder: two tilts, two offsets,
//! radius). The middle of the points' extent is laid at half the tank's height: rim and floor correct
//! that later.

use super::similarity::Similarity;
use super::sparse::{SparseModel, SparseView};
use crate::error::{Error, Result};
use crate::math::robust::{Loss, median, spread};
use crate::optics::{Mat3, Tank, Vec3};
use nalgebra::{SMatrix, SVector, Vector2};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The first tank frame and how well the points bear it out.
#[derive(Debug, Clone)]
pub struct Start {
    /// `tank_from_sfm`.
    pub tank_from_sfm: Similarity,
    /// Indices of the model's points that lie on the belts' cylinder.
    pub on_belts: Vec<usize>,
    /// Robust standard deviation of those points' distance from the cylinder, mm.
    pub scatter_mm: f64,
    /// Extent of those points along the axis after laying their middle at half the height, mm.
    pub extent_mm: [f64; 2],
}

/// Direction of the turning axis in the model's frame, down; fails where the views do not turn, or
/// where it does not run down the pictures.
///
/// # Errors
/// Fewer than three views, views that do not turn, pictures lying on their side.
pub fn turning_axis(views: &[SparseView]) -> Result<Vec3> {
    if views.len() < 3 {
        return Err(Error::failed(format!("{} registered views do not give the tank's axis", views.len()))
            .help("at least three photographs must register; see the advice on masks and belts"));
    }
    let sum: Mat3 = views.iter().map(|v| v.rotation).sum();
    let eigen = (sum.transpose() * sum).symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| eigen.eigenvalues[j].total_cmp(&eigen.eigenvalues[i]));
    let n = views.len() as f64;
    let second = eigen.eigenvalues[order[1]].max(0.0).sqrt() / n;
    if second > 0.999 {
        return Err(Error::failed("the registered views hardly turn about the tank: its axis cannot be told")
            .help("the table must turn at least some 10 degrees over the photographs"));
    }
    let axis: Vec3 = eigen.eigenvectors.column(order[0]).into();
    let in_camera = sum * axis / n;
    if in_camera.y.abs() < 0.3 {
        return Err(Error::failed("the tank's axis does not run down the photographs")
            .help("turn the photographs upright before the run (the plant on top)"));
    }
    Ok(axis * in_camera.y.signum())
}

/// Finds the first tank frame; `belt_radius_mm` is that of the printed surface.
///
/// # Errors
/// Views that give no axis, too few points, points that lie on no cylinder.
pub fn start(model: &SparseModel, tank: &Tank, belt_radius_mm: f64) -> Result<Start> {
    let axis = turning_axis(&model.views)?;
    if model.points.len() < 30 {
        return Err(Error::failed(format!("structure from motion found only {} points", model.points.len()))
            .help("the belts need a random print of high contrast; check that the mask shows them"));
    }
    let points: Vec<Vec3> = model.points.iter().map(|p| p.position).collect();
    let cameras: Vec<Vec3> = model.views.iter().map(SparseView::centre).collect();
    let mut fit = first_circle(&points, &cameras, axis)?;
    for _ in 0..30 {
        if fit.improve(&points) < 1e-10 {
            break;
        }
    }
    let sigma = fit.sigma(&points).max(1e-6 * fit.radius);
    let on_belts: Vec<usize> =
        (0..points.len()).filter(|&k| fit.miss(&points[k]).abs() < (6.0 * sigma).min(0.05 * fit.radius)).collect();
    if on_belts.len() < 30 || on_belts.len() * 4 < points.len() {
        return Err(Error::failed(format!(
            "only {} of {} points lie on a common cylinder",
            on_belts.len(),
            points.len()
        ))
        .help("the belts must lie flat on the tank's outer wall, and the mask must show the belts alone"));
    }
    let scale = belt_radius_mm / fit.radius;
    let down = fit.axis;
    let right = any_perpendicular(&down);
    let rotation = Mat3::from_rows(&[right.transpose(), down.cross(&right).transpose(), down.transpose()]);
    let mut heights: Vec<f64> = on_belts.iter().map(|&k| down.dot(&points[k]) * scale).collect();
    heights.sort_by(f64::total_cmp);
    let at = |q: f64| heights[((heights.len() - 1) as f64 * q).round() as usize];
    let (low, high) = (at(0.005), at(0.995));
    let shift = 0.5 * tank.height_mm - 0.5 * (low + high);
    let mut translation_mm = -(rotation * fit.foot) * scale;
    translation_mm.z = shift;
    let tank_from_sfm = Similarity { scale, rotation, translation_mm };
    let first = tank_from_sfm.point(&cameras[0]);
    Ok(Start {
        tank_from_sfm: tank_from_sfm.turned(-first.y.atan2(first.x)),
        on_belts,
        scatter_mm: sigma * scale,
        extent_mm: [low + shift, high + shift],
    })
}

fn any_perpendicular(axis: &Vec3) -> Vec3 {
    let k = axis.iamin();
    let mut e = Vec3::zeros();
    e[k] = 1.0;
    axis.cross(&e).normalize()
}

/// A cylinder: all points at `radius` from the line `foot + t axis`.
#[derive(Debug, Clone)]
struct Cylinder {
    axis: Vec3,
    foot: Vec3,
    radius: f64,
}

impl Cylinder {
    fn miss(&self, x: &Vec3) -> f64 {
        let d = x - self.foot;
        (d - self.axis * self.axis.dot(&d)).norm() - self.radius
    }

    fn sigma(&self, points: &[Vec3]) -> f64 {
        spread(points.iter().map(|x| self.miss(x)))
    }

    /// One reweighted Gauss-Newton step (Cauchy, scale twice the robust spread); returns its size
    /// relative to the radius.
    fn improve(&mut self, points: &[Vec3]) -> f64 {
        let scale = (2.0 * self.sigma(points)).max(1e-9 * self.radius);
        let e1 = any_perpendicular(&self.axis);
        let e2 = self.axis.cross(&e1);
        let mut normal = SMatrix::<f64, 5, 5>::zeros();
        let mut right = SVector::<f64, 5>::zeros();
        for x in points {
            let d = x - self.foot;
            let along = self.axis.dot(&d);
            let w = d - self.axis * along;
            let rho = w.norm();
            if rho < 1e-12 {
                continue;
            }
            let (c1, c2) = (w.dot(&e1) / rho, w.dot(&e2) / rho);
            let miss = rho - self.radius;
            let weight = Loss::Cauchy.weight(miss / scale);
            // Tilts are taken per radius so that all five unknowns have one unit.
            let j = SVector::from([-c1, -c2, -c1 * along / self.radius, -c2 * along / self.radius, -1.0]);
            normal += j * j.transpose() * weight;
            right -= j * (miss * weight);
        }
        for k in 0..5 {
            normal[(k, k)] *= 1.0 + 1e-9;
        }
        let Some(step) = normal.cholesky().map(|c| c.solve(&right)) else { return 0.0 };
        self.foot += e1 * step[0] + e2 * step[1];
        self.axis = (self.axis + (e1 * step[2] + e2 * step[3]) / self.radius).normalize();
        self.radius += step[4];
        step.norm() / self.radius
    }
}

/// The circle through three points, seen along the axis, near which most points lie and outside of
/// which all cameras stand.
fn first_circle(points: &[Vec3], cameras: &[Vec3], axis: Vec3) -> Result<Cylinder> {
    let e1 = any_perpendicular(&axis);
    let e2 = axis.cross(&e1);
    let flat = |x: &Vec3| Vector2::new(x.dot(&e1), x.dot(&e2));
    let flat_points: Vec<_> = points.iter().map(flat).collect();
    let flat_cameras: Vec<_> = cameras.iter().map(flat).collect();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut best: Option<(f64, Vector2<f64>, f64)> = None;
    for _ in 0..2000 {
        let [a, b, c] = std::array::from_fn(|_| flat_points[rng.random_range(0..flat_points.len())]);
        let Some((centre, radius)) = circle_through(a, b, c) else { continue };
        if flat_cameras.iter().any(|x| (x - centre).norm() < 1.05 * radius) {
            continue;
        }
        let tolerance = 0.01 * radius;
        let cost: f64 =
            flat_points.iter().map(|p| (((p - centre).norm() - radius).abs() / tolerance).min(1.0).powi(2)).sum();
        if best.is_none_or(|b| cost < b.0) {
            best = Some((cost, centre, radius));
        }
    }
    let (_, centre, radius) = best.ok_or_else(|| {
        Error::failed("the points of structure from motion lie on no cylinder inside the ring of cameras")
            .help("check the mask: it must show the printed belts alone")
    })?;
    let mut along: Vec<f64> = points.iter().map(|x| x.dot(&axis)).collect();
    let foot = e1 * centre.x + e2 * centre.y + axis * median(&mut along);
    Ok(Cylinder { axis, foot, radius })
}

fn circle_through(a: Vector2<f64>, b: Vector2<f64>, c: Vector2<f64>) -> Option<(Vector2<f64>, f64)> {
    let (p, q) = (b - a, c - a);
    let det = 2.0 * (p.x * q.y - p.y * q.x);
    if det.abs() < 1e-9 * (p.norm_squared() + q.norm_squared()) {
        return None;
    }
    let (pp, qq) = (p.norm_squared(), q.norm_squared());
    let centre = Vector2::new((q.y * pp - p.y * qq) / det, (p.x * qq - q.x * pp) / det);
    Some((a + centre, centre.norm()))
}
