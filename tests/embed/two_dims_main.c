#include "two_dims.h"
#include <stdio.h>

int main(void)
{
    printf("%d %d\n", bonds_2d(), bonds_3d());
    return 0;
}
