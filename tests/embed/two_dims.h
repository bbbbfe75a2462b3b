/* Bonds of a family with m = 3, from the file of each dimension; -1 on failure. */
int bonds_2d(void);
int bonds_3d(void);
