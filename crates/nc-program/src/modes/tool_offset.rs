//! Offsets of tools: what the control's table adds to positions, as far as it is told.

use crate::dialect::{FlowStyle, ToolOffset, M};
use crate::modes::modal::Plane;
use crate::modes::request::Request;
use crate::modes::tool::{called, Tool};
use crate::run::Runner;

/// In the place of a tool offset's number where the block gives the offset itself.
const GIVEN: i32 = -1;

/// In the place of a tool's number where a program calls it by a name.
const BY_NAME: i32 = -2;

impl Runner<'_> {
    /// The tool that T calls: it comes into use, with the offset that it brings where the control has it so.
    pub(crate) fn apply_tool(&mut self, request: &Request) {
        let (before, word) = (self.tool_called(), request.word(b'T'));
        if let Some(tool) = request.get(b'T') {
            let by_name = self.word_text(word).contains('"');
            self.state.modal.tool = if by_name { BY_NAME } else { self.tool_number(tool.round() as i32, word) };
        }
        if request.changes_tool {
            self.state.modal.spindle_tool = self.state.modal.tool;
        }
        if self.calls_radii_by_d() {
            self.state.radius_called = request.get(b'D').or(self.state.radius_called);
        }
        let tool = self.tool_called();
        let other = tool != before || tool == BY_NAME && word >= 0;
        let changed = request.changes_tool || other && self.changes_by_t();
        // Of Klartext the tool's length alone makes a difference, which `call_tool` looks at.
        if changed && self.program.dialect().tool_offset != ToolOffset::Call {
            self.state.frame.rename([true; 3]);
        }
        match self.program.dialect().tool_offset {
            ToolOffset::InT if word >= 0 => self.table_offset(self.state.modal.tool % 100, word),
            ToolOffset::Edge(letter) => self.use_edge(request, letter, changed),
            ToolOffset::Call if word >= 0 => self.call_tool(request, word),
            _ => {}
        }
    }

    /// T as of four digits: of six, where the control has such, the first three are the tool, the others its offset.
    fn tool_number(&mut self, tool: i32, word: i32) -> i32 {
        let digits = self.word_text(word).bytes().filter(u8::is_ascii_digit).count();
        if digits != 6 || !self.program.dialect().rules.six_digit_tools {
            return tool;
        }
        let (tool, offset) = (tool / 1000, tool % 1000);
        if offset > 99 {
            self.note_opaque(word, "the offset of the tool is taken as zero");
        }
        tool * 100 + if offset > 99 { 0 } else { offset }
    }

    /// The T word of the tool in the spindle, as far as it is known.
    pub(crate) fn tool_called(&self) -> i32 {
        self.state.modal.tool_in_use()
    }

    /// Whether a D of any block calls the register of radii that later blocks compensate with: Fanuc's and Haas' mills.
    fn calls_radii_by_d(&self) -> bool {
        let dialect = self.program.dialect();
        dialect.flow == FlowStyle::Macro && dialect.tool_offset == ToolOffset::Code
    }

    /// Whether T alone changes the tool: on lathes, and where no M06 was met on controls that may do without it.
    fn changes_by_t(&self) -> bool {
        let dialect = self.program.dialect();
        match dialect.tool_offset {
            ToolOffset::InT | ToolOffset::Call => true,
            ToolOffset::Edge(_) => self.state.modal.spindle_tool == -1,
            _ => dialect.m_code(6.0) != Some(M::ChangeTool),
        }
    }

    /// T and D of a Sinumerik, TG and OG of an Okuma: the edge's lengths. A new tool comes with edge 1, 0 takes them away,
    /// and in another plane they go to other axes.
    fn use_edge(&mut self, request: &Request, letter: u8, changed: bool) {
        let (plane, given) = (self.state.modal.plane, request.get(letter));
        let moved = plane != self.state.edge.1 && self.state.frame.tool != [0.0; 3];
        if !(changed || given.is_some() || moved) {
            return;
        }
        let kept = if changed { 1 } else { self.state.edge.0 };
        let edge = given.map_or(kept, |edge| edge.round() as i32);
        self.state.edge = (edge, plane);
        let tool = self.tool_called();
        let known = called(&self.options.tools, tool, Some(edge)).filter(|_| tool > 0);
        let offset = if edge == 0 || tool == 0 { Some([0.0; 3]) } else { known.and_then(|tool| lengths(tool, plane)) };
        let word = if given.is_some() { request.word(letter) } else { request.word(b'T') };
        if offset.is_none() && word >= 0 && !self.options.tools.is_empty() {
            self.note_opaque(word, "the offset in the control's table is taken as zero");
        }
        let frame = &self.state.frame;
        let known = frame.tool_is_known && offset.is_some();
        let axes = offset.map_or([true; 3], |offset| [0, 1, 2].map(|axis| !known || offset[axis] != frame.tool[axis]));
        self.use_tool_offset(tool.saturating_mul(1000).saturating_add(edge), offset, axes);
    }

    /// TOOL CALL: the tool's length and DL along its axis; DR is added to its radius.
    fn call_tool(&mut self, request: &Request, word: i32) {
        let delta = |letter: u8| request.get(letter).unwrap_or(0.0) * self.state.modal.mm();
        let (longer, wider, third) = (delta(b'd'), delta(b'g'), self.state.modal.plane.axes().2);
        let tool = self.state.modal.tool;
        let whole = request.get(b'T').is_some_and(|number| number == f64::from(tool));
        let table = called(&self.options.tools, tool, None).and_then(|tool| tool.length);
        let defined =
            || self.state.defined_tools.iter().rev().find(|(number, _)| *number == tool).map(|(_, length)| *length);
        let length = table.or_else(defined).filter(|_| whole);
        let length = if tool == 0 { Some(0.0) } else { length.map(|length| length + longer) };
        if length.is_none() && !self.options.tools.is_empty() {
            self.note_opaque(word, "the tool table's length is taken as zero");
        }
        self.state.oversize = wider;
        let offset = length.map(|length| [0, 1, 2].map(|axis| if axis == third { length } else { 0.0 }));
        // Between lengths that are both known the tool's tip stands at a known place.
        let known = self.state.frame.tool_is_known && offset.is_some();
        self.use_tool_offset(tool, offset, [0, 1, 2].map(|axis| axis == third && !known));
    }

    /// `TOOL DEF 5 L+12.5 R+4`: the tool's length, where the block states it.
    pub(crate) fn define_tool(&mut self, word: i32) {
        let text = self.whole_text(word).replace(',', ".");
        let number = text.trim_start_matches(|letter: char| !letter.is_ascii_digit());
        let digits = number.find(|letter: char| !letter.is_ascii_digit()).unwrap_or(number.len());
        let (number, rest) = number.split_at(digits);
        let length =
            rest.split_whitespace().find_map(|part| part.strip_prefix('L')).and_then(|value| value.parse().ok());
        if let Some((number, length)) = number.parse().ok().zip(length.filter(|length: &f64| length.is_finite())) {
            self.state.defined_tools.push((number, length * self.state.modal.mm()));
        }
    }

    /// What is taken from a position of the machine to make it one of the program. Of a Sinumerik G53 and SUPA leave the
    /// tool's offset in force, of others they do not.
    pub(crate) fn machine_origin(&self) -> [f64; 3] {
        let frame = &self.state.frame;
        match self.program.dialect().tool_offset {
            ToolOffset::Edge(_) => [0, 1, 2].map(|axis| frame.total()[axis] - frame.tool[axis]),
            _ => frame.total(),
        }
    }

    /// Brings a tool offset into force along some axes, called by that number; one that is not known counts as none.
    fn use_tool_offset(&mut self, number: i32, offset: Option<[f64; 3]>, axes: [bool; 3]) {
        let frame = &mut self.state.frame;
        let tool = offset.unwrap_or_default();
        if number != frame.tool_number || tool != frame.tool {
            frame.rename(axes);
        }
        (frame.tool_number, frame.tool_is_known) = (number, offset.is_some());
        frame.tool_is_subtracted = false;
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
        let tool = called(&self.options.tools, number, None);
        let known = tool.and_then(|tool| tool.length.map(|length| [0.0, 0.0, length]).or(tool.offset));
        let offset = if number == 0 { Some([0.0; 3]) } else { known };
        if offset.is_none() {
            self.note_opaque(word, "the tool table's length offset is taken as zero");
        }
        let offset = offset.map(|offset| if adds { offset } else { offset.map(|value| -value) });
        let shifted = offset.unwrap_or_default();
        let axes = self.length_axes();
        let axes = [0, 1, 2].map(|axis| axes[axis] || shifted[axis] != 0.0);
        if adds == self.state.frame.tool_is_subtracted {
            self.state.frame.rename(axes);
        }
        self.use_tool_offset(number, offset, axes);
        self.state.frame.tool_is_subtracted = !adds;
    }

    /// T0101: the offset of that number in the tool table, 0 for none; one that is not known is said.
    pub(crate) fn table_offset(&mut self, number: i32, word: i32) {
        let known = called(&self.options.tools, number, None).and_then(|tool| tool.offset);
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

/// Lengths of an edge along X, Y, Z. Of a turning tool, which is given by its X and Z as in G18, length 1 goes to Y in G17
/// and to Z in G19; that of a mill or drill goes to the axis across the plane.
fn lengths(tool: &Tool, plane: Plane) -> Option<[f64; 3]> {
    match (tool.offset, tool.length, plane) {
        (Some(offset), _, Plane::Zx) => Some(offset),
        (Some([first, third, second]), _, Plane::Xy) => Some([second, first, third]),
        (Some([first, third, second]), _, Plane::Yz) => Some([third, second, first]),
        (None, Some(length), Plane::Xy) => Some([0.0, 0.0, length]),
        (None, Some(length), Plane::Zx) => Some([0.0, length, 0.0]),
        (None, Some(length), Plane::Yz) => Some([length, 0.0, 0.0]),
        (None, None, _) => None,
    }
}
