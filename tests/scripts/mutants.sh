#!/bin/sh
# tools/mutants.py on a small tree: faults that its test sees, one that it does not see, one without an effect.
. tests/lib/script.sh
find_python 'import resource, subprocess'
[ -n "$python" ] || skip_all "python3 is not installed"
command -v objcopy > /dev/null || skip_all "objcopy is not installed"
tool=$root/tools/mutants.py
cd "$dir" || exit 1
mkdir -p src/core tests/core tests/scripts build
cat > src/core/sum.h <<'END'
int sum_of(const int *x, int count);
int sum_unseen(int a, int b);
END
cat > src/core/sum.c <<'END'
#include "core/sum.h"

/* The sum + of = all. */
int sum_of(const int *x, int count)
{
    int sum = 0;
    for (int k = 0; k < count; k++)
        sum += x[k];
    return sum;
}

int sum_unseen(int a, int b)
{
    int none = 0;
    none += 1;
    return a * b;
}
END
cat > tests/core/test_sum.c <<'END'
/* dims: 1 2 */
#include "core/sum.h"
int main(void)
{
    static const int x[3] = {5, 7, 11};
    return sum_of(x, 3) != 23;
}
END
export CC="${CC:-cc}" DEV='-std=c99 -O1 -g -fPIC -w' DEV_TEST='-std=c99 -O1'
for d in 1 2 3; do
    mkdir -p build/obj${d}d/core
    $CC $DEV -DPD_DIM=$d -Isrc -c src/core/sum.c -o build/obj${d}d/core/sum.o
done
cp -r src before

$python "$tool" --list --seed 1 --count 1000 > log
check "a list ends with as many as there are" grep -q '^\([0-9]*\) mutants, 0 built' log
check "comments hold no faults" sh -c '! grep -q "sum.c:3:" log'
check "the same seed gives the same faults" sh -c "$python '$tool' --list --seed 1 --count 1000 | cmp -s - log"
check "another seed gives another order" sh -c "! $python '$tool' --list --seed 2 --count 1000 | cmp -s - log"
$python "$tool" --at core/sum.c:7 > log 2>&1
check "faults of a loop, its bounds and its step" \
    grep -q '^3 mutants, 3 built, 3 with an effect, 3 killed, 0 survived$' log
$python "$tool" --at core/sum.c:8 > log 2>&1
check "faults of what is summed" grep -q ', 0 survived$' log
check "the test that sees it is named" grep -q 'killed .*tests/core/test_sum.c [12]D: status 1' log
$python "$tool" --at core/sum.c:16 > log 2>&1
check "a fault that no test sees" grep -q '^1 mutants, 1 built, 1 with an effect, 0 killed, 1 survived$' log
check "it is shown" grep -q '+ return a / b;' log
$python "$tool" --at core/sum.c:15 > log 2>&1
check "faults without an effect" grep -q ', 0 with an effect, 0 killed, 0 survived$' log
# a shell test that runs a program from another folder
mkdir drivers
cat > drivers/scene.c <<'END'
#include "src/core/sum.h"
int main(void) { return sum_unseen(6, 3) != 18; }
END
# shellcheck disable=SC2016
echo 'programs=$PWD/$PROGRAMS; cd /; "$programs/pd2d"' > tests/scripts/scene.sh
$python "$tool" --at core/sum.c:16 > log 2>&1
check "a shell test sees it" grep -q 'killed .*tests/scripts/scene.sh: status 1' log
check "the sources are as they were" diff -r src before
# the map: lines that no test executes, tests that are chosen, and sources that have changed since
$python "$tool" --unseen --tests test_sum > log 2>&1
check "lines that no test executes are listed" grep -q '^src/core/sum.c:16: return a \* b;$' log
check "lines that a test executes are not" sh -c '! grep -q "sum.c:8:" log'
$python "$tool" --at core/sum.c:16 --tests test_sum > log 2>&1
check "a line that no test executes is named" \
    grep -q '^SURVIVED, since no test executes the line: src/core/sum.c:16' log
sed 's/int sum_of(const/\n&/' before/core/sum.c > src/core/sum.c
for d in 1 2 3; do # shellcheck disable=SC2086
    $CC $DEV -DPD_DIM=$d -Isrc -c src/core/sum.c -o build/obj${d}d/core/sum.o
done
$python "$tool" --at core/sum.c:9 --old-map > log 2>&1
check "an old map finds lines by their text" \
    sh -c 'grep -q ", 0 survived$" log && ! grep -q "tests to run" log && grep -q "killed .*test_sum" log'
score
