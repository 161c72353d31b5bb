//! Collision.
