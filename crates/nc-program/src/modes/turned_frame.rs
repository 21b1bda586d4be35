//! Codes that turn, mirror or scale the coordinates of what follows.

use crate::dialect::FlowStyle;
use crate::finding::{self, Severity};
use crate::modes::linear::Linear;
use crate::modes::modal::Compensation;
use crate::modes::request::Request;
use crate::reading::names::skip_blank;
use crate::reading::number;
use crate::run::{Runner, AXES};
use crate::values::parameters::Key;

/// Indices of `Frame::parts`.
pub(crate) const MIRRORS: usize = 0;
pub(crate) const SCALES: usize = 1;
pub(crate) const TURNS: usize = 2;
const SCALES_AXES: usize = 3;

impl Runner<'_> {
    /// G68: the plane is turned by R about the point given, in the place of a turn before it. Under G91, without R or the
    /// centre, and with a direction in space (I, J, K), machine data or the place where the tool stands decide.
    pub(crate) fn rotate(&mut self, request: &Request, word: i32) {
        let (plane, given) = (self.state.modal.plane, self.given(request));
        let (angle, (first, second, _)) = (self.angle_of_turn(request), plane.axes());
        let known = [given[first], given[second], angle].iter().all(|value| value.is_some_and(f64::is_finite));
        if !known || self.state.modal.incremental || request.any(b"IJKABC") {
            return self.unfollowed(word);
        }
        let about = given.map(|value| value.unwrap_or(0.0));
        let scaled = self.state.frame.parts[SCALES];
        let even = scaled.is_none_or(|scaled| scaled.of_circles(plane).is_some_and(|(_, mirrored)| !mirrored));
        if !even || !self.stays(TURNS, about) {
            return self.unfollowed(word);
        }
        self.set_part(TURNS, Some(Linear::turn(plane, angle.unwrap_or(0.0), about)), word);
    }

    /// R in degrees; without a decimal point it counts thousandths, or whole ones, as lengths count steps.
    fn angle_of_turn(&mut self, request: &Request) -> Option<f64> {
        let angle = request.get(b'R')?;
        let point = self.program.dialect().rules.point.filter(|_| request.pointless.has(b'R') && angle != 0.0);
        let Some(point) = point else { return Some(angle) };
        let what = "an angle without a decimal point counts thousandths or whole degrees";
        let steps = self.ask(point, Severity::Error, request.word(b'R'), what)?;
        Some(if steps == 0.0 { angle / 1000.0 } else { angle })
    }

    /// ROT, SCALE and MIRROR (`anew`) take the place of all shifts and turns before them, AROT, ASCALE and AMIRROR add to them;
    /// cycles 8, 10, 11 and 26 of Klartext set one of the four.
    pub(crate) fn turn_frame(&mut self, anew: bool, word: i32) {
        let text = self.whole_text(word);
        if self.program.dialect().flow == FlowStyle::Labels {
            return self.turn_by_cycle(&text, word);
        }
        let Some(linear) = self.linear_of(&text, word) else { return self.unfollowed(word) };
        let linear = linear.unless_none();
        let changes = linear.is_some() || anew && self.state.frame.parts[0].is_some();
        if changes && self.refuses_new_frame(word) {
            return;
        }
        if anew {
            self.shift(&Request::new(), false);
        }
        self.reframe(|frame| {
            let before = frame.parts[0];
            let together = before.into_iter().chain(linear).reduce(|outer, inner| outer.after(&inner));
            frame.parts[0] = together.and_then(Linear::unless_none);
        });
    }

    /// The turn, mirror or scaling in the plane that a word of Sinumerik states; `None` for any other.
    fn linear_of(&mut self, text: &str, word: i32) -> Option<Linear> {
        let head = text.find(|letter: char| !letter.is_ascii_alphabetic()).unwrap_or(text.len());
        let (name, plane) = (text[..head].trim_start_matches('A').to_owned(), self.state.modal.plane);
        let values = self.named_values(word, head)?;
        let axis = |name: &str| AXES.iter().position(|letter| name.as_bytes() == [*letter]);
        match name.as_str() {
            "ROT" | "ROTS" => {
                let (mut angle, is_solid) = (0.0, name == "ROTS");
                for (name, value) in &values {
                    match axis(name) {
                        Some(_) if *value == 0.0 => {}
                        about if !is_solid && (name == "RPL" || about == Some(plane.axes().2)) => angle += value,
                        _ => return None,
                    }
                }
                Some(Linear::turn(plane, angle, [0.0; 3]))
            }
            "SCALE" | "MIRROR" => {
                let mut factors = [1.0; 3];
                for (of, value) in &values {
                    let factor = if name == "MIRROR" { -1.0 } else { *value };
                    factors[axis(of)?] = Some(factor).filter(|factor| *factor != 0.0)?;
                }
                Some(Linear::scaled(factors, [0.0; 3]))
            }
            _ => None,
        }
    }

    /// Names and values of a word, from a byte of its text on: `X2 Y=R1`. `None` where there is anything else.
    fn named_values(&mut self, word: i32, head: usize) -> Option<Vec<(String, f64)>> {
        let found = *self.program.word(word)?;
        let (mut at, end, mut values) = (found.start as usize + head, found.end(), Vec::new());
        loop {
            let source = self.program.source();
            at = skip_blank(source, at);
            if at >= end {
                return Some(values);
            }
            let letters = source[at..end].iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
            let name = String::from_utf8_lossy(&source[at..at + letters]).to_ascii_uppercase();
            at = skip_blank(source, at + letters);
            at = if source.get(at) == Some(&b'=') { skip_blank(source, at + 1) } else { at };
            let (value, after) = self.value(at);
            if letters == 0 || after <= at || after > end || !value.is_finite() {
                return None;
            }
            values.push((name, value));
            at = after;
        }
    }

    /// Cycles 8 (mirror), 10 (turn) and 11 (scale) about the datum, 26 (scale axes) about its own centre, each in the place
    /// of the one before; planes only where they turn nothing.
    fn turn_by_cycle(&mut self, text: &str, word: i32) {
        let names = ["DEF 8.1", "DEF 11.1", "DEF 10.1", "DEF 26.1", "MIRROR", "SCALE", "ROTATION"];
        let named = names.iter().position(|name| text.contains(name));
        let part = named.map(|named| named % 4);
        let head = named.and_then(|named| Some(text.find(names[named])? + names[named].len())).unwrap_or(text.len());
        let linear = match part {
            Some(_) if text[head..].trim() == "RESET" => Some(Linear::scaled([1.0; 3], [0.0; 3])),
            part => part.and_then(|part| self.linear_of_cycle(part, text, head, word)),
        };
        match part {
            Some(part) if linear.is_some() => self.set_part(part, linear, word),
            None if leaves_plane(text) => {
                // The control computes where A, B and C go for it.
                for number in (120..=122).filter(|_| text.contains("SPATIAL") && text.contains("TABLE ROT")) {
                    self.state.store.set(Key::Number(number), 0.0);
                }
            }
            _ => self.unfollowed(word),
        }
    }

    fn linear_of_cycle(&mut self, part: usize, text: &str, head: usize, word: i32) -> Option<Linear> {
        if part == MIRRORS {
            let mut factors = [1.0; 3];
            for name in text[head..].split_whitespace().filter(|name| *name != "AXIS") {
                factors[AXES.iter().position(|letter| name.as_bytes() == [*letter])?] = -1.0;
            }
            return Some(Linear::scaled(factors, [0.0; 3]));
        }
        let (values, plane) = (self.named_values(word, head)?, self.state.modal.plane);
        if part == SCALES_AXES {
            return self.scaled_axes(&values);
        }
        match values.as_slice() {
            [(name, angle)] if part == TURNS && name == "ROT" => Some(Linear::turn(plane, *angle, [0.0; 3])),
            [(name, angle)] if part == TURNS && name == "IROT" => {
                let (first, second, third) = plane.axes();
                let before = self.state.frame.parts[TURNS];
                if before.is_some_and(|turn| turn.matrix[third][third] != 1.0) {
                    return None; // of another plane
                }
                let before =
                    before.map_or(0.0, |turn| turn.matrix[second][first].atan2(turn.matrix[first][first]).to_degrees());
                // The control's step is coarser: an angle and its opposite are none.
                Some(Linear::turn(plane, ((before + angle) * 1e9).round() / 1e9, [0.0; 3]))
            }
            [(name, factor)] if part == SCALES && name == "SCL" && *factor == 1.0 => {
                Some(Linear::scaled([1.0; 3], [0.0; 3]))
            }
            [(name, factor)] if part == SCALES && name == "SCL" && *factor > 0.0 => {
                let mut factors = [*factor; 3];
                let parameter = self.program.dialect().rules.plane_scaling?;
                if self.ask(parameter, Severity::Error, word, "the tool's axis is scaled or not")? != 0.0 {
                    factors[plane.axes().2] = 1.0;
                }
                Some(Linear::scaled(factors, [0.0; 3]))
            }
            _ => None,
        }
    }

    /// Cycle 26: factors of axes, and the centre that stays. Axes that it does not name are scaled by none before it.
    fn scaled_axes(&self, values: &[(String, f64)]) -> Option<Linear> {
        let (mut factors, mut centre) = ([1.0; 3], [0.0; 3]);
        for (name, value) in values {
            let axis = |letter: &str| AXES.iter().position(|axis| letter.as_bytes() == [*axis]);
            match name.strip_prefix("CC") {
                Some(letter) => centre[axis(letter)?] = value * self.state.modal.mm(),
                None => factors[axis(name)?] = Some(*value).filter(|factor| *factor > 0.0)?,
            }
        }
        let names = |axis: usize| values.iter().any(|(name, _)| name.as_bytes() == [AXES[axis]]);
        let before = self.state.frame.parts[SCALES_AXES];
        let keeps = |axis: usize| before.is_some_and(|before| before.matrix[axis][axis] != 1.0) && !names(axis);
        (!(0..3).any(keeps)).then(|| Linear::scaled(factors, centre))
    }

    /// Mirrors, scales or turns in the place of what did so before. Refused where the order of two of them would matter.
    pub(crate) fn set_part(&mut self, part: usize, linear: Option<Linear>, word: i32) {
        let linear = linear.and_then(Linear::unless_none);
        if self.state.frame.parts[part] == linear {
            return;
        }
        let by_cycle = self.program.dialect().flow == FlowStyle::Labels;
        let others =
            |other: usize| other != part && (by_cycle || other > part) && self.state.frame.parts[other].is_some();
        if (0..4).any(others) || self.refuses_new_frame(word) {
            return self.unfollowed(word);
        }
        self.reframe(|frame| frame.parts[part] = linear);
    }

    /// Refuses to turn coordinates under compensation: how the tool comes from one frame to the other is not followed.
    pub(crate) fn refuses_new_frame(&mut self, word: i32) -> bool {
        let compensates = self.state.modal.compensation != Compensation::Off;
        if compensates {
            let message = "coordinates are turned, mirrored or scaled under G41 or G42".to_owned();
            self.warn(finding::OPAQUE, self.word_start(word), message, "end the compensation before it, by G40 or R0");
        }
        compensates
    }

    /// Reports coordinates that are turned where a control has to find them as they were; returns whether they are.
    pub(crate) fn is_turned(&mut self) -> bool {
        let bound = matches!(self.program.dialect().flow, FlowStyle::Macro | FlowStyle::Labels);
        let turned = bound && self.state.frame.linear.is_some();
        if turned {
            let message = "coordinates are set anew while they are turned, mirrored or scaled: this is not followed";
            let hint = "end the rotation, the mirror and the scaling before it";
            self.warn(finding::OPAQUE, self.block_start(), message.into(), hint);
        }
        turned
    }

    /// Reports a way to a place of the machine along axes that are turned, mirrored or scaled: manuals of Fanuc's kind forbid it.
    pub(crate) fn check_turned_way(&mut self, request: &Request) {
        let Some(linear) = self.state.frame.linear.filter(|_| self.program.dialect().flow == FlowStyle::Macro) else {
            return;
        };
        let is_own = |axis: usize| (0..3).all(|other| linear.matrix[axis][other] == f64::from(u8::from(axis == other)));
        if (0..3).any(|axis| !is_own(axis) && (request.get(AXES[axis]).is_some() || !self.names_axis(request))) {
            let message = "a way to a place of the machine along an axis that is turned, mirrored or scaled: this is not followed";
            let hint = "end the rotation, the mirror and the scaling before it";
            self.warn(finding::OPAQUE, self.block_start(), message.into(), hint);
        }
    }

    /// An arc has to stay one where it is turned, mirrored and scaled.
    pub(crate) fn require_circles(&mut self) {
        let plane = self.state.modal.plane;
        if self.state.frame.linear.is_some_and(|linear| linear.of_circles(plane).is_none()) {
            let message = "an arc whose axes are scaled differently, or turned out of its plane".to_owned();
            let hint = "write it as lines, or scale both axes of its plane alike";
            self.refuse(finding::ARC, self.block_start(), message, hint);
        }
    }
}

/// Whether cycle 19 or PLANE SPATIAL leaves the plane as it is, every angle 0, and states the way of the axes to it.
fn leaves_plane(text: &str) -> bool {
    let spatial = text.find("SPATIAL");
    if spatial.is_some() && !text.contains("STAY") && !text.contains("TURN") {
        return false;
    }
    let head = spatial.map_or_else(|| text.find(".1").map(|at| at + 2), |at| Some(at + "SPATIAL".len()));
    let (bytes, mut at) = (text.as_bytes(), head.unwrap_or(text.len()));
    while at < bytes.len() {
        let letters = bytes[at..].iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
        let value = at + letters;
        let blanks = bytes[value..].iter().take_while(|byte| matches!(byte, b' ' | b'=')).count();
        let found = Some(letters).filter(|letters| *letters > 0).and_then(|_| number::read(bytes, value + blanks));
        let same = match (&text[at..value], found) {
            ("", _) => !bytes[at].is_ascii_digit(),
            ("F", Some(_)) | ("STAY" | "TURN" | "SEQ" | "FMAX" | "TABLE" | "COORD" | "ROT", None) => true,
            // An increment of nothing leaves the turn before it.
            (name, Some((given, _))) => given == 0.0 && !name.starts_with('I'),
            _ => false,
        };
        if !same {
            return false;
        }
        at = found.map_or(value.max(at + 1), |(_, end)| end);
    }
    true
}
