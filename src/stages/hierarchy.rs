//! Makes roots of the pieces: parents, orders, where a root goes on and what springs from it.
//! In: pieces (with diameters, where they are measured). Out: system.json (roots, repairs).

use crate::error::Result;
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::roots::{HierarchyParams, Pieces, arrange};
use serde::Serialize;

/// The hierarchy with its parameters.
#[derive(Debug, Clone, Serialize)]
pub struct Hierarchy {
    /// How roots are told apart.
    #[serde(flatten)]
    pub params: HierarchyParams,
}

impl Stage for Hierarchy {
    const NAME: &'static str = "hierarchy";
    const VERSION: u32 = 12;

    fn run(&self, inputs: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let pieces: Pieces = inputs.one("pieces")?.json("pieces.json")?;
        output.json("system.json", &arrange(&pieces, &self.params)?)
    }
}
