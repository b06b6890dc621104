//! What stands behind the roots of a study's photographs: the rule by which each view's background is chosen, and what is
//! learned with it.
//!
//! Views of one still room ([`super::still`]) take their background from the turn when they are [`FEWEST`] or more and the
//! turn leaves no more of their pixels' colours unexplained than the window does (medians of the absolute differences,
//! within a tenth); all others take the window. So a camera that is carried around, a room that moves and single
//! views in another light are judged by their own surroundings.

use super::drift::{Even, gains};
use super::noise::Noise;
use super::roots::{RootColour, ridge_pixels};
use super::still::{groups, room_pixels};
use super::turn::{Group, Still, Turn};
use super::{Background, Codes, clear, px_per_mm, window};
use crate::error::{Error, Result};
use crate::optics::{Mat3, Tank, Vec3, View};
use crate::photo::Picture;
use ndarray::{Array2, Array3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Fewest views whose turn tells a background: two roots in front of one pixel still leave a majority.
pub const FEWEST: usize = 5;
/// How much more the turn may leave unexplained than the window before the window is taken.
const WORSE: f32 = 1.1;
/// Room pixels that tell drift and groups.
const ROOM_PIXELS: usize = 6000;
/// Views that teach the roots' colour, and that judge a background.
const TEACHERS: usize = 12;
const JUDGES: usize = 4;
/// A background teaches where its deviation is below so many of the noise's.
const QUIET: f32 = 1.7;

/// What was found, for every view.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Room {
    /// Gain of each view and channel against the middle of all, linear light.
    pub gains: Vec<[f64; 3]>,
    /// Still background of each view; none where the window is taken.
    pub stills: Vec<Option<usize>>,
    /// Noise of the photographs.
    pub noise: Noise,
    /// The roots.
    pub roots: RootColour,
    /// Width of thin roots, mm at the axis: the first quartile over ridge pixels ([`ridge_pixels`]), where there are enough. A scale
    /// for thicker ones would lose them, theirs keeps thick ones.
    pub root_width_mm: Option<f64>,
    /// Whether the roots' colour was learned; else it is a guess.
    pub learned: bool,
    /// Weights of R, G, B codes that tell roots from what is mostly behind them, one noise deviation each unit.
    pub weights: [f64; 3],
    /// How backgrounds were chosen, one sentence a group of views.
    pub reasons: Vec<String>,
}

/// Finds what is behind the roots in undistorted `photos`; `views` have ideal lenses, in the same order. `window_mm` is the
/// edge of the window at the tank's axis. Returns the room and its still backgrounds.
///
/// # Errors
/// Where sizes differ, no photograph shows the water, or `check` asks to stop.
pub fn find(
    photos: &[Picture],
    views: &[View],
    tank: &Tank,
    background: Background,
    window_mm: f64,
    check: &(dyn Fn() -> Result<()> + Sync),
) -> Result<(Room, Vec<Still>)> {
    for (photo, view) in photos.iter().zip(views) {
        let (height, width, _) = photo.dim();
        if (height, width) != (view.lens.height, view.lens.width) {
            return Err(Error::failed(format!(
                "background: photograph of {width} x {height} px, lens of {} x {}",
                view.lens.width, view.lens.height
            ))
            .help("the lens must be that of the photograph"));
        }
    }
    let clear: Vec<Array2<bool>> = views.iter().map(|view| clear::clear_pixels(view, tank)).collect();
    if photos.len() != views.len() || clear.iter().flatten().filter(|c| **c).count() < 100 {
        return Err(Error::failed("no photograph shows the water")
            .help("check the tank's belts and height, and whether the cameras belong to the photographs"));
    }
    let room = room_pixels(views, tank, ROOM_PIXELS);
    let gains = gains(photos, &room);
    let even: Vec<Even> = gains.iter().map(|&g| Even::new(g)).collect();
    check()?;
    let of_group = match background {
        Background::Window => (0..photos.len()).collect(),
        _ => groups(photos, &even, &room),
    };
    let study = Study { photos, views, even: &even, clear: &clear, background, window_mm };
    let mut chosen: Vec<(Vec<usize>, Turn)> = Vec::new();
    let mut reasons = Vec::new();
    let mut by_window = Vec::new();
    for number in 0..=of_group.iter().copied().max().unwrap_or(0) {
        let members: Vec<usize> = (0..photos.len()).filter(|&v| of_group[v] == number).collect();
        check()?;
        match study.turn(&members) {
            (Some(turn), reason) => {
                reasons.push(reason);
                chosen.push((members, turn));
            }
            (None, reason) => {
                reasons.extend((!reason.is_empty()).then_some(reason));
                by_window.extend(members);
            }
        }
    }
    if !by_window.is_empty() {
        reasons.push(format!(
            "{} of {} views: background from the window around each pixel",
            by_window.len(),
            photos.len()
        ));
    }
    let mut stills = vec![None; photos.len()];
    for (n, (members, _)) in chosen.iter().enumerate() {
        members.iter().for_each(|&v| stills[v] = Some(n));
    }
    by_window.sort_unstable();
    let noise = study.noise(&chosen, &by_window);
    let (colours, mut widths_mm, behind) = study.teach(&chosen, &noise);
    check()?;
    let variance = f64::from(noise.variance(behind[1] as f32));
    let learned = RootColour::learn(&colours, variance);
    let roots = learned.unwrap_or_else(|| guess(behind, variance));
    let backgrounds = chosen
        .into_iter()
        .map(|(members, turn)| {
            check()?;
            Ok(study.group(&members).still(turn, &roots, &noise))
        })
        .collect::<Result<_>>()?;
    let weights = weights(&roots, behind, variance);
    let root_width_mm = learned.and_then(|_| ranked(&mut widths_mm, 0.25)).map(f64::from);
    Ok((Room { gains, stills, noise, roots, root_width_mm, learned: learned.is_some(), weights, reasons }, backgrounds))
}

/// Roots of no known colour: gray, twenty noise deviations brighter than what is behind them.
fn guess(behind: [f64; 3], variance: f64) -> RootColour {
    let step = 20.0 * variance.sqrt();
    let mut covariance = [[0.0; 3]; 3];
    (0..3).for_each(|c| covariance[c][c] = (0.5 * step).powi(2));
    RootColour { mean: behind.map(|b| b + step), covariance }
}

/// Fisher's direction between roots and what is mostly behind them.
fn weights(roots: &RootColour, behind: [f64; 3], variance: f64) -> [f64; 3] {
    let noise = Mat3::identity() * variance;
    let towards = Vec3::from(roots.mean) - Vec3::from(behind);
    let direction = (Mat3::from(roots.covariance) + noise).try_inverse().map_or(towards, |inverse| inverse * towards);
    (direction / (variance.sqrt() * direction.norm()).max(1e-12)).into()
}

/// Colours and widths, mm, of ridge pixels, and colours of what is behind.
type Taught = (Vec<[f32; 3]>, Vec<f32>, Vec<[f32; 3]>);

/// The photographs and how to look at them.
struct Study<'a> {
    photos: &'a [Picture],
    views: &'a [View],
    even: &'a [Even],
    clear: &'a [Array2<bool>],
    background: Background,
    window_mm: f64,
}

impl Study<'_> {
    fn group<'a>(&'a self, members: &'a [usize]) -> Group<'a> {
        Group { photos: self.photos, even: self.even, clear: self.clear, members }
    }

    /// Codes of a view without its drift.
    fn codes(&self, v: usize) -> Codes {
        let photo = &self.photos[v];
        let (height, width, _) = photo.dim();
        let mut codes = Array3::zeros((height, width, 3));
        for ((y, x), _) in self.clear[v].indexed_iter().filter(|(_, clear)| **clear) {
            for (c, code) in self.even[v].pixel(photo, y, x).into_iter().enumerate() {
                codes[[y, x, c]] = code;
            }
        }
        codes
    }

    fn window(&self, v: usize, codes: &Codes) -> Codes {
        window::background(codes, &self.clear[v], self.window_mm * px_per_mm(&self.views[v]))
    }

    /// The turn's background where it is to be taken, and why or why not.
    fn turn(&self, members: &[usize]) -> (Option<Turn>, String) {
        let of = format!("{} of {} views", members.len(), self.photos.len());
        match self.background {
            Background::Window => return (None, String::new()),
            Background::Turn if members.len() > 1 => {
                return (Some(self.group(members).modes()), format!("{of}: background from the turn, as asked"));
            }
            _ if members.len() < FEWEST => {
                return (None, format!("{of} see a room of their own: too few for its turn"));
            }
            _ => {}
        }
        let turn = self.group(members).modes();
        let judges: Vec<usize> = spread_over(members, JUDGES);
        let left: Vec<[f32; 2]> = judges
            .par_iter()
            .map(|&v| {
                let codes = self.codes(v);
                let by_window = self.window(v, &codes);
                [self.unexplained(v, &codes, &turn.mean, Some(&turn)), self.unexplained(v, &codes, &by_window, None)]
            })
            .collect();
        let [by_turn, by_window] = [0, 1].map(|n| left.iter().map(|l| l[n]).sum::<f32>() / left.len() as f32);
        let said = format!("the turn leaves {by_turn:.1} codes unexplained, the window {by_window:.1}");
        if by_turn <= WORSE * by_window {
            (Some(turn), format!("{of}: background from the turn; {said}"))
        } else {
            (None, format!("{of}: {said}"))
        }
    }

    /// Median over the clear pixels of the colours' mean absolute difference from a background. A mode of few views is
    /// pulled towards each of them: made good.
    fn unexplained(&self, v: usize, codes: &Codes, background: &Codes, turn: Option<&Turn>) -> f32 {
        let mut left: Vec<f32> = self.clear[v]
            .indexed_iter()
            .filter(|(_, clear)| **clear)
            .step_by(7)
            .map(|((y, x), _)| {
                let n = turn.map_or(1e9, |t| f32::from(t.count[[y, x]]).max(1.5));
                let sum: f32 = (0..3).map(|c| (codes[[y, x, c]] - background[[y, x, c]]).abs()).sum();
                sum / 3.0 * (n / (n - 1.0)).sqrt()
            })
            .collect();
        let middle = left.len() / 2;
        if left.is_empty() { 0.0 } else { *left.select_nth_unstable_by(middle, f32::total_cmp).1 }
    }

    /// Noise from the turns, else from what the windows leave.
    fn noise(&self, chosen: &[(Vec<usize>, Turn)], by_window: &[usize]) -> Noise {
        let mut pairs: Vec<(f32, f32)> = chosen.iter().flat_map(|(_, turn)| turn.levels()).collect();
        if pairs.is_empty() {
            for v in spread_over(by_window, JUDGES) {
                let codes = self.codes(v);
                let left = self.unexplained(v, &codes, &self.window(v, &codes), None);
                // The mean of three absolute normal deviations is 0.8 of one.
                let variance = (left / 0.8).powi(2);
                let clear = self.clear[v].indexed_iter().filter(|(_, clear)| **clear).step_by(101);
                pairs.extend(clear.map(|((y, x), _)| (codes[[y, x, 1]], variance)));
            }
        }
        Noise::fit(&pairs)
    }

    /// Colours of ridge pixels, and the middle colour of what is behind.
    fn teach(&self, chosen: &[(Vec<usize>, Turn)], noise: &Noise) -> (Vec<[f32; 3]>, Vec<f32>, [f64; 3]) {
        let teachers = spread_over(&(0..self.photos.len()).collect::<Vec<_>>(), TEACHERS);
        let taught: Vec<Taught> = teachers
            .par_iter()
            .map(|&v| {
                let codes = self.codes(v);
                let turn = chosen.iter().find(|(members, _)| members.contains(&v)).map(|(_, turn)| turn);
                let own = turn.is_none().then(|| self.window(v, &codes));
                let background = own.as_ref().unwrap_or_else(|| &turn.expect("one of the two").mean);
                let shape = self.clear[v].dim();
                let deviations = Array2::from_shape_fn(shape, |(y, x)| {
                    let square = |c: usize| {
                        let behind = background[[y, x, c]];
                        (codes[[y, x, c]] - behind).powi(2) / noise.variance(behind)
                    };
                    if self.clear[v][[y, x]] { (square(0) + square(1) + square(2)).sqrt() } else { 0.0 }
                });
                let sure = Array2::from_shape_fn(shape, |(y, x)| {
                    self.clear[v][[y, x]] && turn.is_none_or(|t| t.is_quiet(y, x, QUIET, noise))
                });
                let colour = |(y, x): (usize, usize), of: &Codes| [0, 1, 2].map(|c| of[[y, x, c]]);
                let ridges = ridge_pixels(&deviations, &sure, px_per_mm(&self.views[v]));
                let behind = sure.indexed_iter().filter(|(_, s)| **s).step_by(101);
                (
                    ridges.iter().map(|ridge| colour(ridge.at, &codes)).collect(),
                    ridges.iter().map(|ridge| ridge.width_mm).collect(),
                    behind.map(|(at, _)| colour(at, background)).collect(),
                )
            })
            .collect();
        let behind: Vec<[f32; 3]> = taught.iter().flat_map(|t| t.2.iter().copied()).collect();
        let behind = [0, 1, 2].map(|c| {
            let mut values: Vec<f32> = behind.iter().map(|b| b[c]).collect();
            ranked(&mut values, 0.5).map_or(64.0, f64::from)
        });
        let widths = taught.iter().flat_map(|t| t.1.iter().copied()).collect();
        (taught.into_iter().flat_map(|t| t.0).collect(), widths, behind)
    }
}

/// The value that a share of the others is below; none of nothing.
fn ranked(values: &mut [f32], share: f64) -> Option<f32> {
    let at = (values.len() as f64 * share) as usize;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(at, f32::total_cmp).1)
}

/// Up to `most` of the list, evenly.
fn spread_over(list: &[usize], most: usize) -> Vec<usize> {
    let count = most.min(list.len());
    (0..count).map(|n| list[n * list.len() / count]).collect()
}
