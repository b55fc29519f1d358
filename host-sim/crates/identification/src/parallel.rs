//! Computes one result for each of several items, on all threads.
//!
//! Rayon does it. Every different iterator type that is mapped and collected takes a second to compile; here Rayon gets only one, over indices.

use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use crate::stop;

/// `of_one` of each item, in the items' order.
pub fn each<T: Send, R: Send>(items: impl IntoIterator<Item = T>, of_one: impl Fn(T) -> R + Sync) -> Vec<R> {
    let slots: Vec<Slot<T, R>> = items.into_iter().map(|item| Slot(Mutex::new((Some(item), None)))).collect();
    on_all_threads(slots.len(), &|index| {
        stop::here();
        let slot = &slots[index];
        if let Some(item) = slot.take() {
            let result = of_one(item);
            slot.keep(result);
        }
    });
    slots.into_iter().filter_map(Slot::result).collect()
}

/// As [`each`]; the error of the first item that has one.
pub fn try_each<T: Send, R: Send, E: Send>(
    items: impl IntoIterator<Item = T>,
    of_one: impl Fn(T) -> Result<R, E> + Sync,
) -> Result<Vec<R>, E> {
    each(items, of_one).into_iter().collect()
}

fn on_all_threads(count: usize, task: &(dyn Fn(usize) + Sync)) {
    (0..count).into_par_iter().for_each(task);
}

/// An item until it is taken, its result from then on. Nothing that can panic runs while it is locked.
struct Slot<T, R>(Mutex<(Option<T>, Option<R>)>);

impl<T, R> Slot<T, R> {
    fn take(&self) -> Option<T> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).0.take()
    }

    fn keep(&self, result: R) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).1 = Some(result);
    }

    fn result(self) -> Option<R> {
        self.0.into_inner().unwrap_or_else(PoisonError::into_inner).1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_come_in_the_order_of_the_items() {
        let squares = each(0..1000_u64, |index| index * index);
        assert!(squares.iter().zip(0..1000).all(|(square, index)| *square == index * index), "{squares:?}");
        assert_eq!(squares.len(), 1000);
        assert!(each(Vec::<u8>::new(), |byte| byte).is_empty());
    }

    #[test]
    fn of_several_errors_the_first_item_s_is_given() {
        let odd = |index: i32| if index % 2 == 0 { Ok(index) } else { Err(index) };
        assert_eq!(try_each(4..100, odd), Err(5));
        assert_eq!(try_each([2, 4], odd), Ok(vec![2, 4]));
    }
}
