/* SPDX-License-Identifier: BSD-3-Clause
 * Common parts of the hosts written in C: the library and its functions, the arguments, a logger that checks messages.
 * Arguments: LIBRARY GUID RESOURCES INPUT FIRST_OUTPUT OUTPUTS, then the host's own. */
#pragma once
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>
#else
#include <dlfcn.h>
#endif

#include "fmi2Functions.h"

#ifdef _WIN32
static HMODULE library;
static void* open_library(const char* path) { return library = LoadLibraryA(path); }
static void* symbol(const char* name) { return (void*)(intptr_t)GetProcAddress(library, name); }
static const char* load_error(void) { return "LoadLibrary failed"; }
#else
static void* library;
static void* open_library(const char* path) { return library = dlopen(path, RTLD_NOW); }
static void* symbol(const char* name) { return dlsym(library, name); }
static const char* load_error(void) { return dlerror(); }
#endif

static const char *guid, *resources;
static fmi2ValueReference input, outputs[2048];
static size_t n_outputs;
static atomic_long messages;

static void* function(const char* name) {
  void* found = symbol(name);
  if (found == NULL) {
    fprintf(stderr, "missing function %s\n", name);
    exit(2);
  }
  return found;
}
#define CALL(name) ((name##TYPE*)function(#name))

/* Reads the six common arguments and opens the library; exits if one is invalid. */
static void take_arguments(int argc, char** argv) {
  if (argc < 7) exit(2);
  guid = argv[2];
  resources = argv[3];
  input = (fmi2ValueReference)atoi(argv[4]);
  n_outputs = (size_t)atoi(argv[6]);
  if (n_outputs > sizeof outputs / sizeof outputs[0]) exit(2);
  for (size_t i = 0; i < n_outputs; ++i) outputs[i] = (fmi2ValueReference)(atoi(argv[5]) + (int)i);
  if (open_library(argv[1]) == NULL) {
    fprintf(stderr, "%s\n", load_error());
    exit(2);
  }
}

static void logger(fmi2ComponentEnvironment e, fmi2String name, fmi2Status status, fmi2String category, fmi2String text,
                   ...) {
  (void)e;
  if (strcmp(name, "plant") != 0 || status == fmi2OK || category[0] == 0 || text[0] == 0) {
    fprintf(stderr, "invalid log message: %s\n", text);
    exit(3);
  }
  ++messages;
}

static const fmi2CallbackFunctions callbacks = {logger, NULL, NULL, NULL, NULL};

static fmi2Component instantiate(void) {
  return CALL(fmi2Instantiate)("plant", fmi2CoSimulation, guid, resources, &callbacks, fmi2False, fmi2False);
}

static int initialize(fmi2Component c, double torque) {
  int bad = CALL(fmi2SetupExperiment)(c, fmi2False, 0, 0, fmi2False, 0);
  bad |= CALL(fmi2EnterInitializationMode)(c);
  bad |= CALL(fmi2SetReal)(c, &input, 1, &torque);
  return bad | CALL(fmi2ExitInitializationMode)(c);
}
