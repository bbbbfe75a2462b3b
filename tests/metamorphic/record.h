/* record: what a run came to: its status and message, its fields and figures in full precision. A run is a process of
 * its own, so that a crash, a hang and an abort of a sanitizer are records, too.
 */
#ifndef METAMORPHIC_RECORD_H
#define METAMORPHIC_RECORD_H
#include <stddef.h>
#include <stdint.h>

typedef enum outcome {
    OUTCOME_DONE = 0,
    OUTCOME_FAILED,  /* the run ended with a message */
    OUTCOME_REFUSED, /* bad input */
    OUTCOME_CRASHED,
    OUTCOME_HUNG
} outcome;

extern const char *const outcome_names[];

typedef struct run_figure {
    char section[16], name[64], key[24], unit[20];
    double value;
} run_figure;

enum { FIELD_NAME = 24 };
#define FIRST_KIND "kind(start)" /* the field of what nodes were at the start */

typedef struct run_field {
    char name[FIELD_NAME], label[48];
    int components;
    double *data; /* [components][cells] x fastest */
} run_field;

/* A file of the output. */
typedef struct run_file {
    char name[80];
    int64_t size;
    uint64_t sum; /* of its bytes */
} run_file;

typedef struct record {
    int outcome;
    char message[768];
    char line[512]; /* the result line, with files */
    int32_t n[3];
    int64_t cells, steps;
    double time, seconds; /* [s] of the scene, of the processor */
    double residual;      /* [-] largest that steps of species have left of a balance */
    int64_t species_steps, species_euler; /* steps of species, and those of first order for want of a second one */
    int32_t changes; /* 1: something is not as it was at the start */
    int32_t figures, fields, files;
    run_figure *figure; /* [figures] */
    run_field *field;   /* [fields] */
    run_file *file;     /* [files] where they were asked for */
} record;

typedef struct run_options {
    int threads;
    int files;           /* 1: write files and keep their sums */
    int resume;          /* with files: stop after so many steps, go on from the checkpoint; 0: do not */
    int tight;           /* 1: solvers at their end; 2: steps of species of first order, too */
    double limit;        /* [s] of processor time */
    const char *folder;  /* scratch */
    const char *program; /* of another dimension, that runs it; NULL: this one */
} run_options;

/* Run a text. The record is for record_free. */
void record_run(const char *text, const run_options *o, record *r);
/* Run the text in this process and write its record to a file descriptor, for the program of another dimension. */
void record_serve(const char *text, const run_options *o, int to);
void record_free(record *r);
/* [s] of the processor that this process and those that it has waited for have had. */
double processor_seconds(void);
const run_figure *record_figure(const record *r, const char *section, const char *name, const char *key);

#endif
