"""What tests share: made-up flights, geometry, graphs, processes and a browser."""
