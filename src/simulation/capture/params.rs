//! What stands before the tank and how it takes pictures: every setting of `[simulate.capture]`.

use crate::optics::{Distortion, Lens};
use crate::simulation::room::RoomParams;
use serde::{Deserialize, Serialize};

/// File format of the photographs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PictureFormat {
    /// JPEG at `jpeg_quality`.
    Jpeg,
    /// PNG, without loss.
    Png,
}

/// Views that are taken in another light than the others.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OtherLight {
    /// Which, counted from 0.
    pub views: Vec<usize>,
    /// Linear light of their pictures over that of the others, per channel: exposure and colour of the light.
    #[serde(default = "unchanged")]
    pub gain: [f64; 3],
    /// Direction towards the lamps, where it is another than `lamp_direction`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lamp_direction: Option<[f64; 3]>,
}

/// Views that are taken with another lens, or another camera, than the others; the picture's size is the same.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OtherLens {
    /// Which, counted from 0.
    pub views: Vec<usize>,
    /// Focal length as on 35 mm film, mm.
    pub focal_35mm: f64,
    /// Principal point beside the picture's centre, shares of the picture's width (x, y).
    pub principal_offset: [f64; 2],
    /// Lens distortion.
    pub distortion: Distortion,
}

fn unchanged() -> [f64; 3] {
    [1.0; 3]
}

/// A capture: camera, table, light and what stands about. Colours are sRGB, 0..1 per channel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CaptureParams {
    /// Number of photographs around the tank, at least 1.
    pub views: usize,
    /// Hand-turned: each turn differs from 360°/views by up to this, degrees.
    pub turn_jitter_deg: f64,
    /// Distance of the table's axis of rotation from the tank's axis, mm.
    pub table_offset_mm: f64,
    /// Picture width, px.
    pub width: usize,
    /// Picture height, px.
    pub height: usize,
    /// Focal length as on 35 mm film (36 mm wide), mm: focal length in px = this / 36 · width.
    pub focal_35mm: f64,
    /// Principal point beside the picture's centre, shares of the picture's width (x, y).
    pub principal_offset: [f64; 2],
    /// Lens distortion: k1, k2, p1, p2, k3 and others as OpenCV's; b1 the horizontal focal length less the vertical one,
    /// px; `model = "fisheye"` with k1 to k4.
    pub distortion: Distortion,
    /// Views through another lens.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub other_lens: Vec<OtherLens>,
    /// Horizontal distance of the camera from the tank's axis, mm; 0: so that the tank fills 88 % of the picture's
    /// height (or width).
    pub distance_mm: f64,
    /// Depth of the camera below the rim, mm (negative: above); not given: at 0.42 of the tank's height.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height_mm: Option<f64>,
    /// Tilt of the optical axis, degrees; positive looks down. Not given: at the middle of the tank.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tilt_deg: Option<f64>,
    /// Roll of the camera about its optical axis, degrees.
    pub roll_deg: f64,
    /// Pan of the optical axis beside the tank's axis, degrees; positive looks to the right.
    pub pan_deg: f64,
    /// The camera is carried around a tank that stands still, with the room, instead of the tank turning before it. Held
    /// by hand it strays: up to 15 % farther away, by 8 % of the tank's height up or down, 1° beside its aim, 3° of roll.
    pub carried: bool,
    /// View before which somebody bumps into the tripod, so that the camera stands otherwise from then on; 0 for none.
    pub bump_view: usize,
    /// How far the bump moves the camera, mm.
    pub bump_mm: f64,
    /// How far the bump turns the camera, degrees.
    pub bump_deg: f64,
    /// Supersampling per side of a pixel that holds detail, 1..8: this squared rays.
    pub supersampling: usize,
    /// Colour of a fully lit root.
    pub root_rgb: [f64; 3],
    /// Relative spread of the roots' brightness from root to root, 0..1.
    pub root_variation: f64,
    /// Colour of the room.
    pub background_rgb: [f64; 3],
    /// Relative strength of the room's gradient and blotches, 0..1 (of linear light).
    pub background_variation: f64,
    /// What stands in the room.
    pub room: RoomParams,
    /// Brightness of the lamps' glow that the front wall mirrors into the pictures as a veil, linear light, 0 for none.
    pub lamp_level: f64,
    /// Brightness of the room behind the camera, over that of the room's colour, linear light: walls mirror it as a veil
    /// before which mirrored roots look dark.
    pub front_level: f64,
    /// Direction towards the lamps as the camera sees it: right, away from the camera, down; any length.
    pub lamp_direction: [f64; 3],
    /// Share of the light on a root that comes from all around, 0..1; the rest comes from the lamps.
    pub ambient: f64,
    /// Loss of light in the water, per mm, per channel.
    pub water_loss_per_mm: [f64; 3],
    /// Follow what walls and water surface mirror: illusory roots, veil.
    pub reflections: bool,
    /// Colour of the inner floor.
    pub floor_rgb: [f64; 3],
    /// Seed of the belts' random print.
    pub belt_seed: u64,
    /// Radius of the table top in tank radii; 0 for none.
    pub table_radii: f64,
    /// Standard deviation of the sensor noise, grey levels of 255.
    pub noise_sigma: f64,
    /// Blur of the picture, standard deviation, px at 968 px picture width (scales with the width).
    pub blur_px: f64,
    /// Greatest displacement of swaying roots, mm.
    pub sway_mm: f64,
    /// Views in which the roots sway, counted from 0; none given: all.
    pub sway_views: Vec<usize>,
    /// Number of specks of dirt on the outer wall.
    pub dirt: usize,
    /// Mean radius of a speck, mm, at most 3.
    pub dirt_mm: f64,
    /// Number of air bubbles on the inner wall.
    pub bubbles: usize,
    /// Mean radius of a bubble, mm, at most 3.
    pub bubble_mm: f64,
    /// Brightness of the lamps' image in a bubble, linear light: a bright spot within a dark rim. 0: bubbles mirror the
    /// room at their rim and have no spot.
    pub bubble_glint: f64,
    /// Number of flat bits (specks, leaves) that hang in the water and turn with the tank.
    pub drifting: usize,
    /// Middle of the bits' half lengths, mm: from a quarter of it to four times it.
    pub drifting_mm: f64,
    /// A green stem above the crown.
    pub stem: bool,
    /// Unsteady exposure: standard deviation of the log of each picture's gain, drawn independently.
    pub exposure_drift: f64,
    /// Slow drift of the exposure: standard deviation over the views of the log of a gain that walks at random.
    pub exposure_walk: f64,
    /// The same of red and of blue beside green.
    pub white_balance_walk: f64,
    /// Views in another light.
    pub other_light: Vec<OtherLight>,
    /// File format of the photographs.
    pub format: PictureFormat,
    /// JPEG quality, 1..100.
    pub jpeg_quality: u8,
}

impl Default for CaptureParams {
    /// 36 photographs of 968 x 648 px with an ordinary camera before a dark room.
    fn default() -> Self {
        Self {
            views: 36,
            turn_jitter_deg: 1.5,
            table_offset_mm: 2.0,
            width: 968,
            height: 648,
            focal_35mm: 36.0,
            principal_offset: [0.004, -0.004],
            distortion: Distortion { k1: -0.08, k2: 0.04, p1: 4e-4, p2: -3e-4, k3: 0.0, ..Distortion::default() },
            other_lens: Vec::new(),
            distance_mm: 0.0,
            height_mm: None,
            tilt_deg: None,
            roll_deg: 0.5,
            pan_deg: 0.3,
            carried: false,
            bump_view: 0,
            bump_mm: 0.0,
            bump_deg: 0.0,
            supersampling: 3,
            root_rgb: [0.86, 0.80, 0.74],
            root_variation: 0.12,
            background_rgb: [0.22, 0.235, 0.255],
            background_variation: 0.25,
            room: RoomParams::default(),
            lamp_level: 0.6,
            front_level: 0.35,
            lamp_direction: [-0.5, -0.6, -0.6],
            ambient: 0.25,
            water_loss_per_mm: [0.0005, 0.0002, 0.0002],
            reflections: true,
            floor_rgb: [0.2, 0.2, 0.22],
            belt_seed: 1,
            table_radii: 1.5,
            noise_sigma: 2.0,
            blur_px: 0.0,
            sway_mm: 0.0,
            sway_views: Vec::new(),
            dirt: 0,
            dirt_mm: 0.6,
            bubbles: 0,
            bubble_mm: 0.6,
            bubble_glint: 0.0,
            drifting: 0,
            drifting_mm: 1.0,
            stem: true,
            exposure_drift: 0.0,
            exposure_walk: 0.0,
            white_balance_walk: 0.0,
            other_light: Vec::new(),
            format: PictureFormat::Jpeg,
            jpeg_quality: 95,
        }
    }
}

impl CaptureParams {
    /// The lens of a view.
    pub fn lens(&self, view: usize) -> Lens {
        match self.other_lens.iter().find(|other| other.views.contains(&view)) {
            Some(other) => self.lens_of(other.focal_35mm, other.principal_offset, other.distortion),
            None => self.lens_of(self.focal_35mm, self.principal_offset, self.distortion),
        }
    }

    fn lens_of(&self, focal_35mm: f64, principal_offset: [f64; 2], distortion: Distortion) -> Lens {
        let width = self.width as f64;
        Lens {
            width: self.width,
            height: self.height,
            focal_px: focal_35mm / 36.0 * width,
            cx: (width - 1.0) / 2.0 + principal_offset[0] * width,
            cy: (self.height as f64 - 1.0) / 2.0 + principal_offset[1] * width,
            distortion,
        }
    }
}
