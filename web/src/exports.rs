//! What WebAssembly exports to a worker of the page.

use std::slice;
use std::sync::Once;

#[link(wasm_import_module = "sagnac")]
unsafe extern "C" {
    /// Receives the units of work that are done, and their total.
    fn progress(done: f64, total: f64);
    /// Receives the last words of the library, as text, before it stops for good.
    fn trouble(text: *const u8, length: usize);
}

/// Passes the message of a panic on, which is lost otherwise.
fn tell_of_panics() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        std::panic::set_hook(Box::new(|panic| {
            let text = panic.to_string();
            // SAFETY: the page reads the text before this returns.
            unsafe { trouble(text.as_ptr(), text.len()) };
        }));
    });
}

/// Room for a message.
#[unsafe(no_mangle)]
extern "C" fn reserve(length: usize) -> *mut u8 {
    Box::into_raw(vec![0_u8; length].into_boxed_slice()).cast()
}

/// Gives back the room of a message or a reply.
///
/// # Safety
/// [`reserve`] or [`call`] gave it with this length, and it is not used any more.
#[unsafe(no_mangle)]
unsafe extern "C" fn release(address: *mut u8, length: usize) {
    // SAFETY: the caller promises it.
    drop(unsafe { Box::from_raw(std::ptr::slice_from_raw_parts_mut(address, length)) });
}

/// Answers the message in the `length` bytes at `address`: the address of the reply in the upper half, its length in the lower one.
///
/// # Safety
/// `address` points to `length` bytes.
#[unsafe(no_mangle)]
unsafe extern "C" fn call(address: *const u8, length: usize) -> u64 {
    // SAFETY: the caller promises it.
    let message = unsafe { slice::from_raw_parts(address, length) };
    tell_of_panics();
    // SAFETY: the page takes any two numbers.
    let report = |done: u64, total: u64| unsafe { progress(done as f64, total as f64) };
    let reply = Box::leak(crate::call(message, &report).into_boxed_slice());
    (reply.as_ptr() as u64) << 32 | reply.len() as u64
}
