//! Brings a later day's tank frame into that of the first by the printed belts.
//! In: reference, later (prints). Out: alignment (JSON; null where the belts hold too little print to go by).

use super::print;
use crate::error::{Error, Result};
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::growth::align::{Alignment, Unmatched, align};
use serde::Serialize;

/// The frame of one day in another's.
#[derive(Debug, Clone, Serialize)]
pub struct Align {}

impl Stage for Align {
    const NAME: &'static str = "align";
    const VERSION: u32 = 2;

    fn run(&self, inputs: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let found: Option<Alignment> = match align(
            &print::read(inputs.one("reference")?)?,
            &print::read(inputs.one("later")?)?,
        ) {
            Ok(found) => Some(found),
            Err(Unmatched::Plain(share)) => {
                let text =
                    "of the belts hold print that tells azimuths apart: the day is brought into place by its roots";
                output.warn(format!("{:.0} % {text}", 100.0 * share));
                None
            }
            Err(Unmatched::Other(agreement)) => {
                return Err(Error::failed(format!(
                    "the belts are not those of the plant's first day: their prints correlate by {agreement:.2} at best"
                ))
                .help("is it another tank, or another plant? mend the list; of a tank that was printed anew, list the days as two plants"));
            }
        };
        output.json("alignment", &found)
    }
}
