/* hold FILE MARK: keeps FILE open for reading, as a viewer does, until MARK is there; two minutes at most. */
#include <stdio.h>
#include <windows.h>

int main(int argc, char **argv)
{
    FILE *file = argc == 3 ? fopen(argv[1], "rb") : NULL, *mark = NULL;
    if (!file) return 1;
    puts("open");
    fflush(stdout);
    for (int k = 0; k < 2400 && !mark; k++) {
        Sleep(50);
        mark = fopen(argv[2], "rb");
    }
    return mark ? 0 : 2;
}
