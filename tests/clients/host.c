/* A host in C: loads the FMU's library, pushes the piston and holds it, prints what it reads as hexadecimal bits. Written
 * from the FMI 2.0 standard, for any platform that a C compiler reaches: `tests/python/test_fmu_platforms.py` runs it under
 * emulators.
 *
 *   host LIBRARY GUID POSITION VELOCITY OUTPUT OUTPUT OUTPUT            the last five are value references
 */
#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef _WIN32
#include <windows.h>
#define open_library(path) ((void *)LoadLibraryA(path))
#define find(library, name) ((void *)GetProcAddress((HMODULE)(library), name))
#else
#include <dlfcn.h>
#define open_library(path) dlopen(path, RTLD_NOW | RTLD_LOCAL)
#define find(library, name) dlsym(library, name)
#endif

typedef void *component;
typedef void (*logger)(void *, const char *, int, const char *, const char *, ...);
typedef struct {
    logger log;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} callbacks;

static int messages;

static void on_message(void *environment, const char *name, int status, const char *category, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    fprintf(stderr, "%s, %s, status %d: ", name, category, status);
    vfprintf(stderr, format, arguments);
    fprintf(stderr, "\n");
    va_end(arguments);
    messages++;
    if (environment != &messages) exit(5);
}

static void *function(void *library, const char *name) {
    void *found = find(library, name);
    if (found == NULL) {
        fprintf(stderr, "%s is not exported\n", name);
        exit(3);
    }
    return found;
}

static void check(int status, const char *what) {
    if (status != 0) {
        fprintf(stderr, "%s: status %d\n", what, status);
        exit(4);
    }
}

int main(int count, char **arguments) {
    if (count != 8) return 2;
    void *library = open_library(arguments[1]);
    if (library == NULL) {
        fprintf(stderr, "%s cannot be loaded\n", arguments[1]);
        return 3;
    }
    component (*instantiate)(const char *, int, const char *, const char *, const callbacks *, int, int) =
        function(library, "fmi2Instantiate");
    int (*setup)(component, int, double, double, int, double) = function(library, "fmi2SetupExperiment");
    int (*enter)(component) = function(library, "fmi2EnterInitializationMode");
    int (*leave)(component) = function(library, "fmi2ExitInitializationMode");
    int (*set)(component, const unsigned *, size_t, const double *) = function(library, "fmi2SetReal");
    int (*get)(component, const unsigned *, size_t, double *) = function(library, "fmi2GetReal");
    int (*step)(component, double, double, int) = function(library, "fmi2DoStep");
    int (*terminate)(component) = function(library, "fmi2Terminate");
    void (*release)(component) = function(library, "fmi2FreeInstance");

    const callbacks host = {on_message, NULL, NULL, NULL, &messages};
    component chamber = instantiate("host", 1, arguments[2], NULL, &host, 0, 0);
    if (chamber == NULL) return 4;
    check(setup(chamber, 0, 0.0, 0.0, 0, 0.0), "fmi2SetupExperiment");
    check(enter(chamber), "fmi2EnterInitializationMode");
    check(leave(chamber), "fmi2ExitInitializationMode");

    unsigned references[5];
    for (int i = 0; i < 5; i++) references[i] = (unsigned)strtoul(arguments[3 + i], NULL, 10);
    const unsigned *inputs = references, *outputs = references + 2;
    double refused = -1.0 / (double)(count - 8);
    if (set(chamber, inputs, 1, &refused) != 2 || messages != 1) {
        fprintf(stderr, "an infinite position was not refused with a message\n");
        return 4;
    }
    for (int k = 0; k < 100; k++) {
        const double pushed = k < 20 ? 0.1 - 0.0025 * k : 0.05;
        const double values[] = {pushed, k < 20 ? -0.25 : 0.0};
        double found[3];
        check(set(chamber, inputs, 2, values), "fmi2SetReal");
        check(step(chamber, k * 0.01, 0.01, 1), "fmi2DoStep");
        check(get(chamber, outputs, 3, found), "fmi2GetReal");
        for (int i = 0; i < 3; i++) {
            uint64_t bits;
            memcpy(&bits, &found[i], sizeof bits);
            printf("%016" PRIx64 "%s", bits, i < 2 ? " " : "\n");
        }
    }
    check(terminate(chamber), "fmi2Terminate");
    release(chamber);
    return 0;
}
