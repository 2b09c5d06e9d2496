//! Sums of products and products of sums: each is made of the other.

use dashu_ratio::RBig;
use rustc_hash::FxHashMap;

use crate::node::Expr;

/// `Σ coefficient · product`; the product 1 stands for the constant.
#[derive(Clone, Default)]
pub(super) struct Sum {
    pub(super) terms: FxHashMap<Expr, RBig>,
}

/// `coefficient · Π base^exponent`
#[derive(Clone)]
pub(super) struct Product {
    pub(super) coefficient: RBig,
    pub(super) powers: FxHashMap<Expr, RBig>,
}
