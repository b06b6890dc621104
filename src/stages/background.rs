//! Learns from all photographs what stands behind the roots, how noisy they are, and what colour roots have.
//! In: photos (undistorted) and cameras (of every view, in the same order). Out: room (JSON), and per still background n
//! background-n (y, x, rgb i16, sixteenths of a code) and variance-n (y, x, rgb f32, codes²).

use super::photographs::picture;
use super::three;
use crate::error::Result;
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::optics::{Tank, View};
use crate::photo::evidence::Background as Choice;
use crate::photo::evidence::room::{Room, find};
use crate::photo::evidence::turn::Still;
use crate::store::Artefact;
use rayon::prelude::*;
use serde::Serialize;

/// The background with its parameters.
#[derive(Debug, Clone, Serialize)]
pub struct Background {
    /// The tank between water and cameras.
    pub tank: Tank,
    /// From the turn, from a window, or as the photographs bear it out.
    pub background: Choice,
    /// Edge of the window, mm at the tank's axis.
    pub window_mm: f64,
}

/// Stored steps per code.
const STEPS: f32 = 16.0;

impl Stage for Background {
    const NAME: &'static str = "background";
    const VERSION: u32 = 1;

    fn peak_bytes(&self) -> u64 {
        // All photographs, and modes and variances of one group.
        1 << 30
    }

    fn run(&self, inputs: &Inputs, output: &mut Output, progress: &Progress) -> Result<()> {
        let photos = inputs.many("photos").par_iter().map(picture).collect::<Result<Vec<_>>>()?;
        let cameras = inputs.many("cameras").iter().map(|camera| camera.json::<View>("view"));
        let views = cameras.map(|view| Ok(view?.ideal())).collect::<Result<Vec<_>>>()?;
        let (room, stills) = find(&photos, &views, &self.tank, self.background, self.window_mm, &|| progress.check())?;
        if !room.learned {
            output.warn("too few lines in the water stand out from what is behind them to learn the roots' colour: roots are taken to be brighter than the room");
        }
        for (n, still) in stills.iter().enumerate() {
            let stored = still.background.mapv(|v| (v * STEPS).round() as i16);
            output.array(&format!("background-{n}"), stored.view().into_dyn(), &["y", "x", "c"])?;
            output.array(&format!("variance-{n}"), still.variance.view().into_dyn(), &["y", "x", "c"])?;
        }
        output.json("room", &room)
    }
}

/// The still background `n` that [`Background`] found.
pub(crate) fn still(artefact: &Artefact, n: usize) -> Result<Still> {
    let background = three(artefact.array::<i16>(&format!("background-{n}"))?.read()?)?;
    Ok(Still {
        background: background.mapv(|v| f32::from(v) / STEPS),
        variance: three(artefact.array::<f32>(&format!("variance-{n}"))?.read()?)?,
    })
}

/// The room that [`Background`] found.
pub(crate) fn room(artefact: &Artefact) -> Result<Room> {
    artefact.json("room")
}
