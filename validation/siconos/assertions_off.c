/* Debian builds Siconos with its assertions, and some of them walk whole graphs for each contact that is added: with 500 contacts
 * they take nine tenths of a step. These are the functions that exist for assertions alone (SiconosGraph.hpp, inside
 * #ifndef NDEBUG); loaded first, they say that all is well, as a build with NDEBUG does. */

#define HOLDS(name) \
    _Bool name(const void *graph) { (void)graph; return 1; }

/* SiconosGraph<Interaction, DynamicalSystem>: state_assert, adjacent_vertices_ok. */
HOLDS(_ZNK12SiconosGraphISt10shared_ptrI11InteractionES0_I15DynamicalSystemE21InteractionProperties25DynamicalSystemProperties15GraphPropertiesE12state_assertEv)
HOLDS(_ZNK12SiconosGraphISt10shared_ptrI11InteractionES0_I15DynamicalSystemE21InteractionProperties25DynamicalSystemProperties15GraphPropertiesE20adjacent_vertices_okEv)

/* SiconosGraph<DynamicalSystem, Interaction>: the same. */
HOLDS(_ZNK12SiconosGraphISt10shared_ptrI15DynamicalSystemES0_I11InteractionE25DynamicalSystemProperties21InteractionProperties15GraphPropertiesE12state_assertEv)
HOLDS(_ZNK12SiconosGraphISt10shared_ptrI15DynamicalSystemES0_I11InteractionE25DynamicalSystemProperties21InteractionProperties15GraphPropertiesE20adjacent_vertices_okEv)
