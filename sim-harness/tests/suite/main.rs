//! The simulator and its command, each part by itself.

mod cave;
mod changed_branch;
mod cli;
mod craft;
mod explorations;
mod faults;
mod fork;
mod homing;
mod hover;
mod huge_geometry;
mod ideal;
mod keys;
mod loss;
mod machine;
mod maps;
mod medium;
mod odometry;
mod order;
mod perch;
mod place;
mod plan;
mod played_back;
mod radio;
mod radios;
mod retirement;
mod verdict;
