//! Offsets of tools: what the control's table adds to positions, as far as it is told.

use crate::modal::Plane;
use crate::request::Request;
use crate::run::Runner;
use crate::tool::called;

/// In the place of a tool offset's number where the block gives the offset itself.
const GIVEN: i32 = -1;

impl Runner<'_> {
    /// Another tool: where its tip stands, only the control knows.
    pub(crate) fn change_tool(&mut self) {
        self.state.frame.rename([true; 3]);
    }

    /// Brings a tool offset into force along some axes, called by that number; one that is not known counts as none.
    fn use_tool_offset(&mut self, number: i32, offset: Option<[f64; 3]>, axes: [bool; 3]) {
        let frame = &mut self.state.frame;
        let tool = offset.unwrap_or_default();
        if number != frame.tool_number || tool != frame.tool {
            frame.rename(axes);
        }
        (frame.tool_number, frame.tool_is_known) = (number, offset.is_some());
        if tool != frame.tool {
            self.reframe(|frame| frame.tool = tool);
        }
    }

    /// G49.
    pub(crate) fn cancel_tool_offset(&mut self) {
        let axes = self.length_axes();
        self.use_tool_offset(0, Some([0.0; 3]), [0, 1, 2].map(|axis| axes[axis] || self.state.frame.tool[axis] != 0.0));
    }

    /// The axes that a row of the table may shift: of a lathe X, too.
    fn length_axes(&self) -> [bool; 3] {
        [self.state.modal.plane == Plane::Zx, false, true]
    }

    /// G43: the row of the tool of H, or of the one in use: its length along Z, else its offset; said where it is not
    /// known. G44 takes it away.
    pub(crate) fn length_offset(&mut self, request: &Request, adds: bool, word: i32) {
        let coming = request.get(b'T').filter(|_| request.changes_tool);
        let number = request.get(b'H').or(coming).map_or(self.tool_in_use(), |number| number.round() as i32);
        let tool = called(&self.options.tools, number);
        let known = tool.and_then(|tool| tool.length.map(|length| [0.0, 0.0, length]).or(tool.offset));
        let offset = if number == 0 { Some([0.0; 3]) } else { known };
        if offset.is_none() {
            self.note_opaque(word, "the tool table's length offset is taken as zero");
        }
        let offset = offset.map(|offset| if adds { offset } else { offset.map(|value| -value) });
        let shifted = offset.unwrap_or_default();
        let axes = self.length_axes();
        self.use_tool_offset(number, offset, [0, 1, 2].map(|axis| axes[axis] || shifted[axis] != 0.0));
    }

    /// T0101: the offset of that number in the tool table, 0 for none; one that is not known is said.
    pub(crate) fn table_offset(&mut self, number: i32, word: i32) {
        let known = called(&self.options.tools, number).and_then(|tool| tool.offset);
        let offset = if number == 0 { Some([0.0; 3]) } else { known };
        if offset.is_none() {
            self.note_opaque(word, "the offset in the control's table is taken as zero");
        }
        self.use_tool_offset(number, offset, [true; 3]);
    }

    /// A tool length offset given in the block.
    pub(crate) fn tool_offset(&mut self, request: &Request) {
        let (given, before) = (self.given(request), self.state.frame.tool);
        let offset = [0, 1, 2].map(|axis| given[axis].unwrap_or(before[axis]));
        self.use_tool_offset(GIVEN, Some(offset), [0, 1, 2].map(|axis| offset[axis] != before[axis]));
    }
}
