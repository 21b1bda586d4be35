//! What parameters read as while a program runs: the program's own values, then those the control keeps.

use crate::dialect::Dialect;
use crate::modes::frame::Frame;
use crate::modes::modal::Modal;
use crate::modes::tool::{called, Tool};
use crate::values::expression::{Values, VACANT};
use crate::values::parameters::{Key, Store, LAST_MACRO_LOCAL};

/// The highest number of a parameter that LinuxCNC has.
const LAST_OF_LINUXCNC: u32 = 5601;

/// Everything an expression can ask for.
pub(crate) struct Scope<'a> {
    pub store: &'a Store,
    pub modal: &'a Modal,
    pub frame: &'a Frame,
    pub position: [f64; 3],
    /// Where the last touch was, mm: NaN along axes that moved towards it.
    pub touched: [f64; 3],
    pub tools: &'a [Tool],
    pub unset_is_zero: bool,
    /// #0 is the parameter that never has a value.
    pub has_null: bool,
    /// Local parameters may be without a value as well: arguments that were left out.
    pub in_macro: bool,
    pub undefined: &'a mut Vec<(Key<'static>, usize)>,
}

impl Values for Scope<'_> {
    fn get(&mut self, key: &Key, at: usize) -> f64 {
        if self.has_null && *key == Key::Number(0) {
            return VACANT;
        }
        let value = self.touched(key).or_else(|| self.store.get(key)).or_else(|| self.system(key));
        if let Some(value) = value {
            return value;
        }
        if self.in_macro && matches!(key, Key::Number(1..=LAST_MACRO_LOCAL)) {
            return VACANT;
        }
        self.undefined.push((key.clone().into_owned(), at));
        if self.unset_is_zero && is_zero(key) {
            0.0
        } else {
            f64::NAN
        }
    }

    fn exists(&self, key: &Key) -> bool {
        self.unset_is_zero && is_numbered(key) || self.store.get(key).or_else(|| self.system(key)).is_some()
    }
}

/// Whether LinuxCNC has a parameter of that number, set or not.
pub(crate) fn is_numbered(key: &Key) -> bool {
    matches!(key, Key::Number(1..=LAST_OF_LINUXCNC))
}

/// Whether LinuxCNC reads a parameter as 0 where nothing has set it.
pub(crate) fn is_zero(key: &Key) -> bool {
    is_numbered(key) && !is_kept(key)
}

/// Whether the control itself gives a parameter its value, by what it does or from its tables.
pub(crate) fn is_kept(key: &Key) -> bool {
    match key {
        Key::Number(number) => matches!(number, 5061..=5070 | 5161..=5189 | 5210..=5219 | 5404..=5428),
        Key::Name(name) => name.starts_with(b"$"),
    }
}

/// Whether a parameter is the place of the tool, now or where it touched.
pub(crate) fn is_place(key: &Key, dialect: &Dialect) -> bool {
    match key {
        Key::Number(number) => dialect.parameters.unset_is_zero && matches!(number, 5061..=5069 | 5420..=5428),
        Key::Name(name) if dialect.parameters.unset_is_zero => {
            matches!(**name, [b'_', b'x' | b'y' | b'z' | b'a' | b'b' | b'c' | b'u' | b'v' | b'w'])
        }
        Key::Name(name) => [&b"$aa_i"[..], b"$aa_m", b"$p_ep"].iter().any(|start| name.starts_with(start)),
    }
}

impl Scope<'_> {
    /// Parameters that the control itself keeps, in program units.
    fn system(&self, key: &Key) -> Option<f64> {
        if let Key::Name(name) = key {
            if let Some(name) = name.strip_prefix(b"$") {
                return self.siemens(name);
            }
        }
        if !self.unset_is_zero {
            return None;
        }
        let mm = self.modal.mm();
        let axis = |first: u32, number: u32| (number - first) as usize;
        match key {
            Key::Number(number @ 5420..=5422) => Some(self.position[axis(5420, *number)] / mm),
            Key::Number(number @ 5401..=5403) => Some(self.frame.tool[axis(5401, *number)] / mm),
            Key::Number(number @ 5211..=5213) => Some(self.frame.register[axis(5211, *number)] / mm),
            Key::Number(5220) => Some(self.frame.active as f64),
            Key::Number(5400) => Some(f64::from(self.modal.tool.max(0))),
            Key::Number(number @ 5221..=5400) => {
                let (system, axis) = ((number - 5221) / 20, (number - 5221) % 20);
                let offsets = self.frame.work.get(&(system as usize + 1)).copied().unwrap_or_default();
                Some(offsets.get(axis as usize).map_or(0.0, |offset| offset / mm))
            }
            Key::Number(5410) => called(self.tools, self.modal.tool_in_use(), None).map(|tool| 2.0 * tool.radius / mm),
            Key::Number(_) => None,
            Key::Name(name) => self.named(name),
        }
    }

    /// Where the last touch was, along an axis that stood: a run does not know how far the others went.
    fn touched(&self, key: &Key) -> Option<f64> {
        let (axis, unit) = match key {
            Key::Number(number @ 5061..=5063) if self.unset_is_zero => ((number - 5061) as usize, self.modal.mm()),
            Key::Name(name) => {
                let axis = [b"$aa_mw[x]", b"$aa_mw[y]", b"$aa_mw[z]"].iter().position(|known| *known == &**name)?;
                (axis, self.modal.axis_mm(axis))
            }
            Key::Number(_) => return None,
        };
        Some(self.touched[axis] / unit).filter(|value| !value.is_nan())
    }

    /// Sinumerik: where the axes are.
    fn siemens(&self, name: &[u8]) -> Option<f64> {
        let name = name.strip_suffix(b"]")?;
        let (name, index) = name.split_at(memchr::memchr(b'[', name)?);
        let axis = [b"[x", b"[y", b"[z"].iter().position(|axis| *axis == index);
        let work = |axis: usize| self.position[axis] / self.modal.axis_mm(axis);
        match (name, axis) {
            (b"aa_iw" | b"p_ep", Some(axis)) => Some(work(axis)),
            (b"aa_im", Some(axis)) => Some(self.frame.machine(self.position)[axis] / self.modal.mm()),
            _ => None,
        }
    }

    fn named(&self, name: &[u8]) -> Option<f64> {
        let flag = |value: bool| Some(f64::from(u8::from(value)));
        match name {
            b"_x" => Some(self.position[0] / self.modal.mm()),
            b"_y" => Some(self.position[1] / self.modal.mm()),
            b"_z" => Some(self.position[2] / self.modal.mm()),
            b"_metric" => flag(!self.modal.inch),
            b"_imperial" => flag(self.modal.inch),
            b"_absolute" => flag(!self.modal.incremental),
            b"_incremental" => flag(self.modal.incremental),
            b"_lathe_diameter_mode" => flag(self.modal.diameter),
            b"_lathe_radius_mode" => flag(!self.modal.diameter),
            b"_feed" => Some(self.modal.feed.max(0.0) / self.modal.mm()),
            b"_rpm" => Some(self.modal.spindle_speed.max(0.0)),
            b"_current_tool" | b"_selected_tool" => Some(f64::from(self.modal.tool.max(0))),
            b"_coord_system" => Some(530.0 + 10.0 * self.frame.active as f64),
            b"_plane" => Some(f64::from(self.modal.plane as u8) * 10.0),
            b"_task" => Some(0.0),
            _ => None,
        }
    }
}
