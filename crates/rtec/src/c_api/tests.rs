//! What C calls, as C calls it.

extern crate std;

use core::mem::MaybeUninit;
use core::ptr::{null, null_mut};

use super::*;
use crate::built::{file, words, PROGRAM};

#[test]
fn periods_until_the_correction_is_in_force() {
    let bytes = file(&words());
    let (mut image, mut state) = (MaybeUninit::<CImage>::uninit(), MaybeUninit::uninit());
    let mut outputs = MaybeUninit::<Outputs>::uninit();
    let mut inputs = Inputs {
        position: [25.0, 0.0, -200.0],
        period_s: 1e-3,
        enable: true,
        homed: true,
        machine_on: true,
        ..Inputs::default()
    };
    inputs.signal[0] = 20.0;
    // SAFETY: everything lives until the end, and is as large as its type.
    let outputs = unsafe {
        let (count, program) = (bytes.len(), PROGRAM.len());
        let (from, serial) = (bytes.as_ptr(), c"4711".as_ptr());
        let (image, state) = (image.as_mut_ptr(), state.as_mut_ptr());
        let init = |serial| rtec_image_init(image, from, count, serial, PROGRAM.as_ptr(), program);
        assert_eq!(init(c"4712".as_ptr()), Refusal::Serial as i32);
        assert_eq!(init(serial), 0);
        rtec_state_init(state);
        for heartbeat in 1..9 {
            inputs.heartbeat = heartbeat;
            rtec_step(
                image,
                state,
                &inputs,
                &Settings::default(),
                outputs.as_mut_ptr(),
            );
        }
        outputs.assume_init()
    };
    assert!((outputs.correction[0] + 0.010).abs() < 1e-12, "{outputs:?}");
    assert!(outputs.enabled && outputs.active);
}

#[test]
fn nothing_comes_of_null_pointers() {
    let mut image = MaybeUninit::<CImage>::uninit();
    // SAFETY: null pointers are allowed, and the image has room.
    unsafe {
        let image = image.as_mut_ptr();
        assert_eq!(rtec_image_init(null_mut(), null(), 0, null(), null(), 0), 1);
        assert_eq!(rtec_image_init(image, null(), 9, null(), null(), 0), 1);
        rtec_state_init(null_mut());
        rtec_step(null_mut(), null_mut(), null(), null(), null_mut());
    }
}

#[test]
fn numbers_have_names() {
    // SAFETY: never null, and ends in zero.
    let text = |text| unsafe { CStr::from_ptr(text) }.to_str().unwrap();
    assert!(text(rtec_refusal(8)).starts_with("hash: "));
    assert!(text(rtec_fault(9)).starts_with("off path: "));
    assert!(text(rtec_fault(-1)).starts_with("unknown: "));
    assert_eq!(rtec_image_size(), size_of::<CImage>());
    assert_eq!(rtec_state_size(), size_of::<Corrector>());
}
