// Distance from the last sample to the soft region, less than 0 inside of it: how far a ray may leap.
// Source: MJ 7 (space leaping by the distance field).
// Object units; 0 where no distance is sampled, and then no ray leaps.
float clearance = 0.0;
