//! The C interface of include/rtec.h. What each pointer must be stands there, and is relied on here: the only `unsafe` code.
//!
//! A null pointer does nothing.

use core::ffi::{c_char, CStr};
use core::mem::size_of;
use core::slice;

use crate::corrector::{Corrector, Inputs, Outputs, Settings};
use crate::image::{Expected, Image, Refusal};
use crate::names::{text, FAULTS, REFUSALS};
use crate::wanted::Asked;

/// An image whose bytes stay as long as it does.
pub type CImage = Image<'static>;

#[cfg(not(test))]
extern "C" {
    /// Is nowhere: a panic that could be reached would leave this symbol undefined, and what is linked would not load.
    fn rtec_would_panic() -> !;
}

#[cfg(not(test))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    // SAFETY: it cannot be called: nothing that calls it links.
    unsafe { rtec_would_panic() }
}

/// Bytes that an image takes.
#[no_mangle]
pub extern "C" fn rtec_image_size() -> usize {
    size_of::<CImage>()
}

/// Bytes that a state takes.
#[no_mangle]
pub extern "C" fn rtec_state_size() -> usize {
    size_of::<Corrector>()
}

/// Reads an image: 0, or the number of a [`Refusal`], and then `image` is as it was.
///
/// # Safety
/// `image` has [`rtec_image_size`] bytes aligned to 64, `bytes` and `program` as many as they say, `serial` ends in zero; none
/// overlaps another. `bytes` stays unchanged as long as the image is used.
#[no_mangle]
pub unsafe extern "C" fn rtec_image_init(
    image: *mut CImage,
    bytes: *const u8,
    count: usize,
    serial: *const c_char,
    program: *const u8,
    program_count: usize,
) -> i32 {
    if image.is_null() || bytes.is_null() {
        return Refusal::Missing as i32;
    }
    // SAFETY: the caller gives `count` bytes that nobody changes, for as long as the image is used.
    let bytes: &'static [u8] = unsafe { slice::from_raw_parts(bytes, count) };
    let expected = Expected {
        // SAFETY: not null, and ends in zero.
        serial: (!serial.is_null()).then(|| unsafe { CStr::from_ptr(serial) }.to_bytes()),
        // SAFETY: not null, and has `program_count` bytes.
        program: (!program.is_null())
            .then(|| unsafe { slice::from_raw_parts(program, program_count) }),
    };
    match Image::read(bytes, expected) {
        // SAFETY: not null, large enough and aligned; what was there needs no end.
        Ok(read) => unsafe { image.write(read) },
        Err(refusal) => return refusal as i32,
    }
    0
}

/// How many signals an image needs.
///
/// # Safety
/// `image` was made by [`rtec_image_init`], and no other thread changes it meanwhile.
#[no_mangle]
pub unsafe extern "C" fn rtec_image_signals(image: *const CImage) -> u32 {
    // SAFETY: null, or an image, which is only read.
    unsafe { image.as_ref() }.map_or(0, |image| image.signals().len() as u32)
}

/// Name and meaning of a refusal, `hash: …`; never null.
#[no_mangle]
pub extern "C" fn rtec_refusal(number: i32) -> *const c_char {
    text(&REFUSALS, number).as_ptr()
}

/// Name and meaning of a fault; never null.
#[no_mangle]
pub extern "C" fn rtec_fault(number: i32) -> *const c_char {
    text(&FAULTS, number).as_ptr()
}

/// Makes a state: switched off, nothing in force.
///
/// # Safety
/// `state` has [`rtec_state_size`] bytes aligned to 64.
#[no_mangle]
pub unsafe extern "C" fn rtec_state_init(state: *mut Corrector) {
    if !state.is_null() {
        // SAFETY: not null, large enough and aligned; what was there needs no end.
        unsafe { state.write(Corrector::new()) };
    }
}

/// One period: what is to be added to the commands.
///
/// # Safety
/// `image` and `state` were made by the functions above and are used by no other thread meanwhile; the others point to their
/// structures, and no two overlap.
#[no_mangle]
pub unsafe extern "C" fn rtec_step(
    image: *mut CImage,
    state: *mut Corrector,
    inputs: *const Inputs,
    settings: *const Settings,
    outputs: *mut Outputs,
) {
    // SAFETY: each is null or points to what its type says, and nobody else uses it during the call.
    let given = unsafe {
        (
            image.as_mut(),
            state.as_mut(),
            inputs.as_ref(),
            settings.as_ref(),
        )
    };
    if let ((Some(image), Some(state), Some(inputs), Some(settings)), false) =
        (given, outputs.is_null())
    {
        // SAFETY: not null, and has room for its structure.
        unsafe { outputs.write(state.step(image, inputs, settings)) };
    }
}

#[cfg(test)]
mod tests;
