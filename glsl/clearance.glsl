// Distance from the last sample of a ray to the soft region, less than 0 inside of it: how far the ray may leap.
// Source: MJ 7 (space leaping by the distance field).
// Object units; 0 where no distance is sampled, and then no ray leaps. Set by what classifies the ray's own samples alone.
float clearance = 0.0;
