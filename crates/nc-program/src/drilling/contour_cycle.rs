//! Cycles of Klartext that mill contours of labels (SL): CYCL DEF 14 names those, 20 to 25 say how deep and how.
//!
//! Their passes are the control's. The path has each contour once, at the clearance height, and the space between the
//! contours' ends in which the passes are.

use crate::drilling::hole::Said;
use crate::modes::modal::{Compensation, Motion};
use crate::order::labels::Direction;
use crate::path::{MoveKind, INHERITED};
use crate::run::Runner;
use crate::values::parameters::Key;

/// Depth, surface and clearance height of these cycles.
const HEIGHTS: [u32; 3] = [1, 5, 7];

impl Runner<'_> {
    /// `CYCL DEF 14.1 CONTOUR LABEL1 /2`.
    pub(crate) fn name_contours(&mut self, word: i32) {
        let text = self.whole_text(word);
        let labels =
            text.get("CYCL DEF 14.1".len()..).unwrap_or("").trim_start_matches(|one: char| !one.is_ascii_digit());
        self.state.contour_labels = labels.split('/').map(|label| label.trim().to_owned()).collect();
    }

    pub(crate) fn mill_contours(&mut self, number: u16) -> Result<(), String> {
        self.require_plain_frame()?;
        let q = |number: u32| self.state.store.get(&Key::Number(number)).filter(|value| value.is_finite());
        let [Some(depth), Some(surface), Some(clearance)] = HEIGHTS.map(q) else {
            return Err("Q1, Q5 and Q7 are not all given".to_owned());
        };
        if !matches!(number, 21..=25) || depth >= 0.0 || clearance <= surface {
            return Err(format!("it mills from {surface} by {depth} and ends at {clearance}"));
        }
        let (mm, third) = (self.state.modal.mm(), self.state.modal.plane.axes().2);
        let (high, bottom) = (clearance * mm, (surface + depth) * mm);
        let (here, next, modal) = (self.block, self.next, self.state.modal);
        if self.state.position[third] != high {
            self.height(MoveKind::Rapid, self.state.position, third, high, INHERITED);
        }
        let first = self.path.len();
        for label in self.state.contour_labels.clone() {
            let labels = self.labels();
            let section = labels.section(&label, here);
            let ends = section.and_then(|start| labels.target(b"0", start, Direction::Forward));
            let (Some(start), Some(end)) = (section, ends) else {
                return Err(format!("there is no LBL {label} to LBL 0 in this program"));
            };
            self.path.enter_call(here);
            self.state.modal.motion = Motion::Line;
            self.run_between(start + 1, end - 1);
            self.close_contour();
            self.path.leave_call();
            (self.block, self.next) = (here, next);
            self.state.modal = modal;
            self.state.modal.compensation = Compensation::Off;
        }
        if self.path.len() == first {
            return Err("no CYCL DEF 14.1 before it names its contours".to_owned());
        }
        let mut space = [[f64::MAX; 3], [f64::MIN; 3]];
        for end in self.path.end.iter().skip(first) {
            for axis in 0..3 {
                (space[0][axis], space[1][axis]) = (space[0][axis].min(end[axis]), space[1][axis].max(end[axis]));
            }
        }
        (space[0][third], space[1][third]) = (bottom, high);
        let said = [7, 5].map(|number| [self.state.defined.said(number), (0, 0)]);
        self.mill(space, high, high, Said::at(said[0], said[1]));
        self.state.frame.rename([0, 1, 2].map(|axis| axis != third));
        Ok(())
    }
}
