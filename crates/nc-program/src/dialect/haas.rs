//! Haas: what differs from Fanuc. G28 alone sends every axis home; M97 calls blocks of the same program.

use super::fanuc::{lathe_a, m_code, mill, FANUC_LATHE, FANUC_MILL};
use super::{Dialect, G, M};
use crate::controls;
use crate::drilling::drill::Drill;
use crate::modes::modal::Modal;

/// Fanuc's settings of speed and smoothing, which Haas has no codes for; G05 is a spindle's.
fn only_fanuc(tenths: u16) -> bool {
    matches!(tenths, 50 | 51 | 80 | 611 | 620 | 630)
}

/// Turning.
pub const HAAS_LATHE: Dialect = Dialect {
    name: "haas-lathe",
    g: |tenths| controls::haas_lathe(tenths).or_else(|| lathe_code(tenths)),
    m: haas_m_code,
    rules: controls::HAAS_LATHE,
    initial: Modal { motion: controls::HAAS_LATHE.starts_with, ..FANUC_LATHE.initial },
    ..FANUC_LATHE
};

/// Milling.
pub const HAAS_MILL: Dialect = Dialect {
    name: "haas-mill",
    g: |tenths| controls::haas_mill(tenths).or_else(|| mill_code(tenths)),
    m: haas_m_code,
    rules: controls::HAAS_MILL,
    initial: Modal { motion: controls::HAAS_MILL.starts_with, ..FANUC_MILL.initial },
    ..FANUC_MILL
};

fn lathe_code(tenths: u16) -> Option<G> {
    Some(match tenths {
        280 => G::Home(0),
        810 | 820 | 860 => G::DrillAlong(Drill::Plain, 2),
        890 => G::DrillAlong(Drill::Ream, 2),
        870 | 880 => G::OpaqueMotion,
        1540 => G::ExtendedOffset,
        140 | 2000 => G::OpaqueMode,
        150 | 1030 | 1870 => G::Inert,
        _ if only_fanuc(tenths) => return None,
        _ => return lathe_a(tenths),
    })
}

fn mill_code(tenths: u16) -> Option<G> {
    Some(match tenths {
        280 => G::Home(0),
        120 | 130 | 470 | 700 | 710 | 720 | 1500 => G::OpaqueBlock,
        1540 => G::ExtendedOffset,
        1030 | 1870 => G::Inert,
        _ if only_fanuc(tenths) => return None,
        _ => return mill(tenths),
    })
}

fn haas_m_code(number: u16) -> Option<M> {
    match number {
        97 => Some(M::CallBlock),
        _ => m_code(number),
    }
}
