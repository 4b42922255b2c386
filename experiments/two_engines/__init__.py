"""Labels of the testbed against those of a second engine, Drake."""
