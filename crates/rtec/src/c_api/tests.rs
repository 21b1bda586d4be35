//! What C calls, as C calls it.

extern crate std;

use core::mem::MaybeUninit;
use core::ptr::{null, null_mut};

use super::*;

#[test]
fn nothing_comes_of_null_pointers() {
    let mut image = MaybeUninit::<CImage>::uninit();
    // SAFETY: null pointers are allowed, and the image has room.
    unsafe {
        assert_eq!(rtec_image_init(null_mut(), null(), 0, null(), null(), 0), 1);
        assert_eq!(
            rtec_image_init(image.as_mut_ptr(), null(), 9, null(), null(), 0),
            1
        );
        rtec_state_init(null_mut());
        rtec_step(null_mut(), null_mut(), null(), null(), null_mut());
    }
}
