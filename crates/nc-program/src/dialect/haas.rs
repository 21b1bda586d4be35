//! Haas: what differs from Fanuc. G28 alone sends every axis home; M97 calls blocks of the same program.

use super::fanuc::{lathe_a, m_code, mill, FANUC_LATHE, FANUC_MILL};
use super::{Dialect, Rules, G, M};
use crate::drill::Drill;

/// Fanuc's settings of speed and smoothing, which Haas has no codes for; G05 is a spindle's.
fn only_fanuc(tenths: u16) -> bool {
    matches!(tenths, 50 | 51 | 80 | 611 | 620 | 630)
}

/// Turning.
pub const HAAS_LATHE: Dialect =
    Dialect { name: "haas-lathe", g: lathe_code, m: haas_m_code, rules: Rules::USUAL, ..FANUC_LATHE };

/// Milling.
pub const HAAS_MILL: Dialect = Dialect { name: "haas-mill", g: mill_code, m: haas_m_code, ..FANUC_MILL };

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
