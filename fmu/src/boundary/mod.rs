//! Shared by all C functions of every FMI version: checks pointers and turns them into slices, keeps panics from the host, and
//! delivers messages once no reference to the instance is held.
//!
//! After a panic an instance returns errors until it is reset; other instances are not affected. Refusals are always reported,
//! unless the host selected categories without them; events only if logging is on. A logger may call back into the instance.

#![allow(unsafe_code)]

mod pointers;
pub mod saved;

pub use pointers::{destination, elements, elements_mut, text};

use crate::plant::simulation::Kind;
use crate::protocol::instance::Instance;
use crate::protocol::message::{Category, Message, Status};
use crate::protocol::refusal::Refusal;
use crate::start_values::{self, Block};
use std::any::Any;
use std::ffi::{CStr, CString, c_char, c_uint, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// A C enumeration without negative members, such as the status returned by functions.
pub type CEnum = c_uint;
/// Result of a call.
pub type Result<T> = std::result::Result<T, Refusal>;

/// The start values; the packager overwrites them in the library's file.
static START_VALUES: [u8; start_values::LENGTH] = start_values::AS_BUILT;

/// Start values and guid of this library; `None` if damaged.
fn of_library() -> Option<Block> {
    // SAFETY: the pointer is to a static array. Volatile, because the packager changes these bytes after compilation.
    let block = unsafe { std::ptr::read_volatile(&raw const START_VALUES) };
    Block::decode(&block)
}

/// A host's logger, for one FMI version. A copy of it remains valid after the instance is freed.
pub trait Listener: Clone {
    /// Rewords a message from the terms of FMI 2.0 to those of this version.
    fn adapt_text(text: &str) -> String {
        text.to_owned()
    }

    /// Converts a refusal from the terms of FMI 2.0 to those of this version.
    fn adapt_refusal(refusal: Refusal) -> Refusal {
        refusal
    }

    /// Delivers a message.
    ///
    /// # Safety
    /// The host's function and pointers must be valid, as the standard requires.
    unsafe fn log(&self, status: Status, category: &CStr, text: &CStr);
}

/// The object behind the host's component or instance pointer.
pub struct Component<L> {
    listener: L,
    wanted: [bool; Category::ALL.len()],
    /// The instance on which calls operate, after their pointers are checked.
    pub instance: Instance,
    broken: bool,
}

impl<L: Listener> Component<L> {
    /// Runs `call`; returns its status and the messages that the host wants.
    fn run(&mut self, function: &str, call: &mut dyn FnMut(&mut Self) -> Result<()>) -> (Status, Vec<Message>) {
        let outcome = catch_unwind(AssertUnwindSafe(|| if self.broken { Err(Refusal::Broken) } else { call(self) }));
        let mut messages = self.instance.messages();
        let status = match outcome {
            Ok(Ok(())) => Status::Ok,
            Ok(Err(refusal)) => {
                let refusal = L::adapt_refusal(refusal);
                let (status, category) = (refusal.status(), refusal.category());
                messages.push(Message { status, category, text: format!("{function} refused: {refusal}") });
                status
            }
            Err(panic) => {
                self.broken = true;
                messages.push(Message {
                    status: Status::Error,
                    category: Category::Error,
                    text: format!(
                        "{function} broke down, which is a fault of the FMU ({}); fmi2Reset makes the instance as new",
                        panic_message(&*panic)
                    ),
                });
                Status::Error
            }
        };
        messages.retain(|message| self.wanted[message.category as usize]);
        (status, messages)
    }

    /// Selects the messages that the host receives; no categories means all.
    ///
    /// # Errors
    /// Categories that the model description does not declare.
    fn choose(&mut self, logging_on: bool, categories: &[String]) -> Result<()> {
        let known = |name: &String| name == "logAll" || Category::ALL.iter().any(|(_, known, _)| known == name);
        if !categories.iter().all(known) {
            return Err(Refusal::NotOffered {
                what: "a category is none of those that the model description declares",
            });
        }
        for (wanted, (category, name, _)) in self.wanted.iter_mut().zip(Category::ALL) {
            let chosen = categories.is_empty() || categories.iter().any(|c| c == name || c == "logAll");
            *wanted = if logging_on { chosen } else { category != Category::Events };
        }
        self.instance.logs_events = self.wanted[Category::Events as usize];
        Ok(())
    }
}

/// Selects the messages that the host receives.
///
/// # Safety
/// As for [`call_guarded`]; `categories` points to `n` texts.
pub unsafe fn choose<L: Listener>(
    c: *mut c_void,
    function: &'static str,
    logging_on: bool,
    n: usize,
    categories: *const *const c_char,
) -> CEnum {
    // SAFETY: as the caller promises.
    unsafe {
        call_guarded::<L>(c, function, &mut |component| {
            let mut chosen = Vec::new();
            for &category in elements(categories, n, "categories")? {
                chosen.push(text(category).ok_or(Refusal::Null { argument: "categories[i]" })?);
            }
            component.choose(logging_on, &chosen)
        })
    }
}

/// Completes an integrator step, which never causes an event or the end of the simulation.
///
/// # Safety
/// Both pointers are NULL or destinations for a flag.
pub unsafe fn completed_step<F: Default>(
    instance: &mut Instance,
    enter_event_mode: *mut F,
    terminate: *mut F,
) -> Result<()> {
    // SAFETY: as the caller promises.
    let (enter, end) =
        unsafe { (destination(enter_event_mode, "enterEventMode")?, destination(terminate, "terminateSimulation")?) };
    instance.completed_step()?;
    (*enter, *end) = (F::default(), F::default());
    Ok(())
}

/// The message of a panic.
fn panic_message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|s| (*s).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default()
}

/// Runs `call` on the component, delivers its messages, and keeps a panic from the host. The call is `dyn`, so that this is
/// compiled once per FMI version rather than into each function.
///
/// # Safety
/// `c` is NULL or a component of [`instantiate`] with this listener that has not been freed, in use by no other thread.
pub unsafe fn call_guarded<L: Listener>(
    c: *mut c_void,
    function: &'static str,
    call: &mut dyn FnMut(&mut Component<L>) -> Result<()>,
) -> CEnum {
    // SAFETY: as the caller promises; the reference ends before the host's logger is called.
    let Some(component) = (unsafe { c.cast::<Component<L>>().as_mut() }) else { return Status::Error as CEnum };
    let (status, messages) = component.run(function, call);
    if !messages.is_empty() {
        let listener = component.listener.clone();
        for message in messages {
            // SAFETY: the listener is the host's, valid as the standard asks.
            unsafe { deliver(&listener, &message) };
        }
    }
    status as CEnum
}

/// Defines the C functions of an FMI version, whose `Host` is in scope: each one's action on the instance behind the component
/// `c`, its first argument. Each returns the status from [`call_guarded`].
macro_rules! c_functions {
    ($(
        $(#[$doc:meta])+
        extern "C" fn $function:ident($($argument:ident: $of:ty),* $(,)?) = |$instance:pat_param| $call:expr;
    )+) => {$(
        $(#[$doc])+
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $function(c: *mut c_void, $($argument: $of),*) -> CEnum {
            // SAFETY: the host's component, pointers, arrays and texts, as the standard requires.
            unsafe {
                boundary::call_guarded::<Host>(c, stringify!($function), &mut |component| {
                    let $instance = &mut component.instance;
                    $call
                })
            }
        }
    )+};
}
pub(crate) use c_functions;

/// Resets the component, also after a panic.
///
/// # Safety
/// As for [`call_guarded`].
pub unsafe fn reset<L: Listener>(c: *mut c_void) -> CEnum {
    // SAFETY: as the caller promises; the reference ends here.
    if let Some(component) = unsafe { c.cast::<Component<L>>().as_mut() } {
        component.broken = false;
    }
    let mut reset = |component: &mut Component<L>| {
        component.instance.reset();
        Ok(())
    };
    // SAFETY: as the caller promises.
    unsafe { call_guarded(c, "fmi2Reset", &mut reset) }
}

/// Creates a component; on failure its listener receives the reason.
///
/// # Safety
/// The listener must be valid.
pub unsafe fn instantiate<L: Listener>(
    listener: L,
    logging_on: bool,
    name: Option<String>,
    guid: Option<String>,
    kind: std::result::Result<Kind, &'static str>,
) -> *mut c_void {
    let made = catch_unwind(|| {
        if name.is_none_or(|name| name.is_empty()) {
            return Err("instanceName is NULL or empty".to_owned());
        }
        let kind = kind?;
        let Some(block) = of_library() else {
            return Err("the start values inside the library are damaged: package the FMU again".into());
        };
        match guid {
            Some(asked) if asked == block.guid => Ok(Instance::new(&block.starts, &block.guid, kind)),
            Some(asked) => Err(format!(
                "guid {asked} differs from {}, the guid of the library: the model description and the library belong to different FMUs",
                block.guid
            )),
            None => Err("the guid is NULL".into()),
        }
    });
    let refused = match made {
        Ok(Ok(mut instance)) => {
            let mut wanted = [true; Category::ALL.len()];
            wanted[Category::Events as usize] = logging_on;
            instance.logs_events = logging_on;
            let component = Component { listener, wanted, instance, broken: false };
            return Box::into_raw(Box::new(component)).cast();
        }
        Ok(Err(why)) => why,
        Err(panic) => panic_message(&*panic),
    };
    let text = format!("the instance was not created: {refused}");
    // SAFETY: as the caller promises.
    unsafe { deliver(&listener, &Message { status: Status::Error, category: Category::Error, text }) };
    std::ptr::null_mut()
}

/// Frees a component; ignores NULL.
///
/// # Safety
/// As for [`call_guarded`]; the component is gone afterwards.
pub unsafe fn free<L>(c: *mut c_void) {
    if !c.is_null() {
        // SAFETY: created by `Box::into_raw` in `instantiate`, and freed once by the host.
        let component = AssertUnwindSafe(unsafe { Box::from_raw(c.cast::<Component<L>>()) });
        let _ = catch_unwind(|| drop(component));
    }
}

/// Delivers a message to the host, worded for its FMI version.
unsafe fn deliver<L: Listener>(listener: &L, message: &Message) {
    let text = L::adapt_text(&message.text);
    // SAFETY: as the caller promises.
    unsafe { listener.log(message.status, &c_string(message.category.name()), &c_string(&text)) };
}

/// Text as a C string, without NUL characters.
pub fn c_string(text: &str) -> CString {
    CString::new(text.replace('\0', "")).unwrap_or_default()
}
