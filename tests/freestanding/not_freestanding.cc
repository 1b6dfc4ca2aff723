// Code that the symbol check must refuse: heap and libm.
#include <cmath>

double* hoard(double x);
double* hoard(double x) { return new double(std::sin(x)); }
