// What the core's C (host/boards/build/c_source.py) needs of CPython. An error in the middle of a function jumps out of it.
#define PY_SSIZE_T_CLEAN
#include <Python.h>
#include <setjmp.h>
#include <stdint.h>

typedef PyObject *core_obj;
static jmp_buf core_out;
#define CORE_NAME(name) #name

static core_obj core_held(core_obj object) {
    if (object == NULL) longjmp(core_out, 1);
    Py_DECREF(object);  // its owner keeps it
    return object;
}
#define core_get(object, name) core_held(PyObject_GetAttrString(object, name))
#define core_item(object, place) core_held(PySequence_GetItem(object, place))
static void core_set(core_obj object, const char *name, core_obj value) {
    if (PyObject_SetAttrString(object, name, value) < 0) longjmp(core_out, 1);
}

static void *core_block(core_obj object) {
    Py_buffer view;
    if (PyObject_GetBuffer(object, &view, PyBUF_SIMPLE) < 0) longjmp(core_out, 1);
    void *items = view.buf;
    PyBuffer_Release(&view);  // arrays of the core keep their size
    return items;
}

static int32_t core_number(core_obj object) {
    long long number = PyLong_AsLongLong(object);
    if (number == -1 && PyErr_Occurred()) longjmp(core_out, 1);
    return (int32_t)number;
}
#define CORE_NUMBER(object) core_number(object)
#define CORE_RESULT(call) PyLong_FromLong(call)
#define CORE_SILENT(call) ((call), Py_NewRef(Py_None))
#define CORE_EXPOSE_N(name, answer, count, ...) \
    static PyObject *py_##name(PyObject *module, PyObject *const *a, Py_ssize_t given) { \
        if (given != count) return PyErr_Format(PyExc_TypeError, "%s takes %d arguments", #name, count); \
        if (setjmp(core_out)) return NULL; \
        return answer(name(__VA_ARGS__)); \
    }
#define CORE_EXPOSE_0(name, answer) CORE_EXPOSE_N(name, answer, 0)
#define CORE_ENTRY(name) { #name, (PyCFunction)py_##name, METH_FASTCALL, NULL },
#define CORE_MODULE(entries) \
    static PyMethodDef core_methods[] = { entries { NULL, NULL, 0, NULL } }; \
    static struct PyModuleDef core_definition = { PyModuleDef_HEAD_INIT, "_core", NULL, -1, core_methods }; \
    PyMODINIT_FUNC PyInit__core(void) { return PyModule_Create(&core_definition); }
